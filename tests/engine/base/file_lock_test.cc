// SPDX-License-Identifier: Apache-2.0
#include "engine/base/file_lock.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include <gmock/gmock.h>

#include "tests/support/test_data.h"

namespace plumbline {
namespace {

class FileLockTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "run.plb";
  std::filesystem::path lock_file_ = folder_.path() / "run.plb.lock";
};

TEST_F(FileLockTest, IsHeldByOneAndLeavesNothing) {
  auto first = FileLock::Acquire(file_);
  ASSERT_TRUE(first.ok()) << first.error().message;
  EXPECT_TRUE(FileLock::IsHeld(file_));
  const auto second = FileLock::Acquire(file_);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(second.error().message,
              testing::AllOf(testing::HasSubstr("run.plb' is open in another window or command"),
                             testing::HasSubstr("process " + std::to_string(getpid()))));
  (*first).reset();
  EXPECT_FALSE(std::filesystem::exists(lock_file_));
  EXPECT_FALSE(FileLock::IsHeld(file_));
  EXPECT_TRUE(FileLock::Acquire(file_).ok());
}

TEST_F(FileLockTest, OfAFileWithTwoNamesIsOne) {
  std::ofstream(file_) << "x";
  std::filesystem::create_symlink(file_, folder_.path() / "other.plb");
  const auto first = FileLock::Acquire(file_);
  EXPECT_FALSE(FileLock::Acquire(folder_.path() / "other.plb").ok());
}

TEST_F(FileLockTest, OfAKilledProcessIsFree) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto lock = FileLock::Acquire(file_);
    [[maybe_unused]] const auto written = write(ends[1], "x", 1);
    pause();
  }
  char byte = 0;
  ASSERT_EQ(read(ends[0], &byte, 1), 1);
  EXPECT_TRUE(FileLock::IsHeld(file_));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(ends[0]);
  close(ends[1]);
  EXPECT_TRUE(std::filesystem::exists(lock_file_));
  EXPECT_FALSE(FileLock::IsHeld(file_));
  EXPECT_TRUE(FileLock::Acquire(file_).ok());
  EXPECT_FALSE(std::filesystem::exists(lock_file_));
}

TEST_F(FileLockTest, IsRemovedByWhoReadsWhenNobodyHoldsIt) {
  std::ofstream(lock_file_) << "process 1 on a machine that was switched off";
  FileLock::RemoveStale(file_);
  EXPECT_FALSE(std::filesystem::exists(lock_file_));
  const auto held = FileLock::Acquire(file_);
  FileLock::RemoveStale(file_);
  EXPECT_TRUE(std::filesystem::exists(lock_file_)) << "somebody holds it";
  EXPECT_FALSE(FileLock::Acquire(file_).ok());
}

TEST_F(FileLockTest, NamesAFolderThatIsNotThere) {
  const auto lock = FileLock::Acquire(folder_.path() / "none" / "run.plb");
  ASSERT_FALSE(lock.ok());
  EXPECT_EQ(lock.error().code, ErrorCode::kIo);
  EXPECT_THAT(lock.error().message, testing::HasSubstr("none/run.plb.lock"));
}

}  // namespace
}  // namespace plumbline
