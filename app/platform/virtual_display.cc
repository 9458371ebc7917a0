// SPDX-License-Identifier: Apache-2.0
#include "app/platform/virtual_display.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>

namespace plumbline {
namespace {

constexpr int kStartMilliseconds = 10'000;

[[noreturn]] void RunServer(int display_fd, const std::string& screen) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  const int nowhere = open("/dev/null", O_RDWR);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  const std::string fd = std::to_string(display_fd);
  execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", screen.c_str(), "-noreset",
         "-nolisten", "tcp", static_cast<char*>(nullptr));
  _exit(127);
}

/// The number that the server writes once it listens; "" if it does not.
std::string ReadDisplayNumber(int fd) {
  std::string number;
  pollfd waiting{fd, POLLIN, 0};
  char c = 0;
  while (poll(&waiting, 1, kStartMilliseconds) > 0 && read(fd, &c, 1) == 1) {
    if (c == '\n') return number;
    number += c;
  }
  return "";
}

}  // namespace

Result<std::unique_ptr<VirtualDisplay>> VirtualDisplay::Start(int width, int height) {
  const std::string screen = std::to_string(width) + "x" + std::to_string(height) + "x24";
  int ends[2];
  if (pipe(ends) != 0) return Error{ErrorCode::kIo, "cannot start Xvfb: no pipe"};
  const pid_t process = fork();
  if (process == 0) {
    close(ends[0]);
    RunServer(ends[1], screen);
  }
  close(ends[1]);
  const std::string number = process > 0 ? ReadDisplayNumber(ends[0]) : "";
  close(ends[0]);
  if (!number.empty() &&
      std::all_of(number.begin(), number.end(), [](unsigned char c) { return std::isdigit(c); })) {
    return std::unique_ptr<VirtualDisplay>(new VirtualDisplay(process, ":" + number));
  }
  int status = 0;
  if (process > 0) {
    kill(process, SIGTERM);
    waitpid(process, &status, 0);
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
    return Error{ErrorCode::kNotFound,
                 "there is no Xvfb on this machine; install it (Debian: apt-get install xvfb)"};
  }
  return Error{ErrorCode::kIo, "Xvfb did not start within ten seconds"};
}

VirtualDisplay::~VirtualDisplay() {
  kill(process_, SIGTERM);
  waitpid(process_, nullptr, 0);
}

}  // namespace plumbline
