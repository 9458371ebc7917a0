// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/child_process.h"

#include <csignal>

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "engine/base/timer.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

class ChildProcess : public testing::Test {
 protected:
  Result<ChildEnd> Shell(const std::string& script, std::optional<double> timeout_s = {}) {
    return RunChild({"/bin/sh", "-c", script}, {folder_.path(), Output(), timeout_s},
                    stop_.get_token());
  }
  std::filesystem::path Output() const { return folder_.path() / "output.txt"; }

  TemporaryFolder folder_;
  std::stop_source stop_;
};

TEST_F(ChildProcess, RunsInItsFolderAndKeepsWhatItSays) {
  ASSERT_TRUE(Shell("echo first > here; echo said; echo wrong >&2")->ok());
  ASSERT_TRUE(Shell("cat here")->ok());
  EXPECT_EQ(*ReadFile(Output()), "said\nwrong\nfirst\n");
}

TEST_F(ChildProcess, TellsHowItEnded) {
  EXPECT_EQ(InWords(Shell("exit 3").value()), "ended with exit code 3");
  EXPECT_EQ(InWords(Shell("kill -SEGV $$").value()), "was ended by signal 11 (Segmentation fault)");
  EXPECT_EQ(InWords(Shell("sleep 60", 0.05).value()), "took too long");
}

TEST_F(ChildProcess, ThatCannotBeStartedIsAnError) {
  const auto end = RunChild({"/no/such/program"}, {folder_.path(), Output(), {}}, {});
  ASSERT_FALSE(end.ok());
  EXPECT_THAT(end.error().message, testing::HasSubstr("No such file"));
}

TEST_F(ChildProcess, IsEndedWithAllThatItStarted) {
  stop_.request_stop();
  const Stopwatch watch;
  const auto end = Shell("sleep 60 & echo $! > other; sleep 60");
  ASSERT_FALSE(end.ok());
  EXPECT_EQ(end.error().code, ErrorCode::kCancelled);
  EXPECT_LT(watch.Milliseconds(), 9000);  // it need not be made to
}

TEST(ShellWords, AreTakenApartAgain) {
  EXPECT_EQ(ShellWords({"a", "--b=c", "it's", "", "$x y"}), "a --b=c 'it'\\''s' '' '$x y'");
}

}  // namespace
}  // namespace plumbline
