// SPDX-License-Identifier: Apache-2.0
// Writes a run and prints the number of every frame that the writer has confirmed, until it is
// killed. run_file_victim RUN.plb [BYTES]: with BYTES no file may grow beyond that, as on a full
// disk; it then prints the error and ends with exit code 3.

#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>

#include <cstdlib>
#include <thread>

#include "engine/recording/run_file.h"
#include "tests/engine/recording/random_run.h"

int main(int argc, char** argv) {
  using namespace plumbline;
  if (argc < 2) return 2;
  if (argc > 2) {
    signal(SIGXFSZ, SIG_IGN);
    const rlim_t bytes = std::strtoull(argv[2], nullptr, 10);
    const rlimit limit{bytes, bytes};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return 2;
  }
  Result<std::unique_ptr<RunWriter>> writer = RunWriter::Create(argv[1], RandomHeader(1));
  if (!writer) {
    fprintf(stderr, "%s\n", writer.error().message.c_str());
    return 3;
  }
  const cv::Mat image = RandomImage(1);
  int reported = 0;
  for (int frame = 0; frame < 100000; ++frame) {
    Status status = (*writer)->Write(RandomFrame(5, frame, 3, 200), image);
    if (status.ok() && frame == 1999 && argc > 2) status = (*writer)->Close();
    if (!status.ok()) {
      const Status closed = (*writer)->Close();
      fprintf(stderr, "%s\n", closed.ok() ? "" : closed.error().message.c_str());
      printf("%d\n", (*writer)->num_written());
      return 3;
    }
    while (reported < (*writer)->num_written()) printf("%d\n", ++reported);
    fflush(stdout);
  }
  return 0;
}
