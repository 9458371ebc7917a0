// SPDX-License-Identifier: Apache-2.0
// Kills an editing process with SIGKILL at random moments; every step that it had finished is
// there.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <future>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/annotation/annotation_project.h"
#include "engine/base/files.h"
#include "tests/engine/annotation/random_edits.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

std::string HashOf(const AnnotationDocument& document) {
  return HashHex(DocumentToJson(document).dump());
}

enum class Since { kStart, kFirstLine };

/// Runs the victim, kills it `milliseconds` after its start or its first line, and returns the
/// lines that it had printed.
std::vector<std::string> RunAndKill(const std::filesystem::path& project, int seed,
                                    double milliseconds, Since since) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    const std::string number = std::to_string(seed);
    execl(PLUMBLINE_ANNOTATION_VICTIM, PLUMBLINE_ANNOTATION_VICTIM, project.c_str(), number.c_str(),
          nullptr);
    _exit(9);
  }
  close(ends[1]);
  std::promise<void> first_line;
  std::thread killer([&, printed = first_line.get_future()] {
    if (since == Since::kFirstLine) printed.wait();
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(milliseconds));
    kill(child, SIGKILL);
  });
  std::string output;
  char buffer[4096];
  for (ssize_t size; (size = read(ends[0], buffer, sizeof(buffer))) > 0;) {
    if (output.empty()) first_line.set_value();
    output.append(buffer, static_cast<std::size_t>(size));
  }
  if (output.empty()) first_line.set_value();
  killer.join();
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << "the victim ended by itself with " << WEXITSTATUS(status);
  close(ends[0]);
  std::vector<std::string> lines;
  std::istringstream stream(output.substr(0, output.rfind('\n') + 1));
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// PLUMBLINE_KILLS=200 for the figure of the documentation.
TEST(KilledAnnotation, LosesNoFinishedEditAndCorruptsNoFile) {
  const char* wanted = std::getenv("PLUMBLINE_KILLS");
  const int kills = wanted ? std::atoi(wanted) : 25;
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "room.json";
  ASSERT_TRUE(AnnotationProject::Create(file, {}).ok());
  Random random({.seed = 77});
  int steps = 0, killed_while_editing = 0;
  std::string last = HashOf({});
  for (int i = 0; i < kills; ++i) {
    const auto lines = i % 4 == 0 ? RunAndKill(file, i, random.Uniform(5, 60), Since::kStart)
                                  : RunAndKill(file, i, random.Uniform(0, 150), Since::kFirstLine);
    steps += static_cast<int>(lines.size());
    killed_while_editing += !lines.empty();
    if (!lines.empty()) last = lines.back();
    auto project = AnnotationProject::Open(file, AnnotationProject::Access::kRead);
    ASSERT_TRUE(project.ok()) << "after kill " << i << ": " << project.error().message;
    EXPECT_TRUE((*project)->warnings().empty()) << (*project)->warnings()[0];
    // The step that was under way may be in the journal and not yet printed: then the document is
    // one step further, and the last printed one is that before it.
    const std::string now = HashOf((*project)->document());
    if (now == last) continue;
    auto writable = AnnotationProject::Open(file);
    ASSERT_TRUE(writable.ok());
    bool one_step = false;
    if ((*writable)->UndoLabel()) {
      ASSERT_TRUE((*writable)->Undo().ok());
      one_step = HashOf((*writable)->document()) == last;
      ASSERT_TRUE((*writable)->Redo().ok());
    }
    // What was under way may have been an undo.
    if (!one_step && (*writable)->RedoLabel()) {
      one_step = (*writable)->Redo().ok() && HashOf((*writable)->document()) == last;
      ASSERT_TRUE((*writable)->Undo().ok());
    }
    EXPECT_TRUE(one_step) << "after kill " << i << " and " << lines.size() << " steps";
    last = now;
  }
  std::printf("%d kills, %d of them while editing, %d steps\n", kills, killed_while_editing, steps);
  EXPECT_GT(killed_while_editing, kills / 2);
}

}  // namespace
}  // namespace plumbline
