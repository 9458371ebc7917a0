// SPDX-License-Identifier: Apache-2.0
// What happens to a run file when things go wrong.

#include <signal.h>
#include <sqlite3.h>
#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "engine/base/check.h"
#include "engine/base/random.h"
#include "engine/recording/frame_codec.h"
#include "engine/recording/run_file.h"
#include "tests/engine/recording/random_run.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

struct Child {
  pid_t pid = 0;
  FILE* output = nullptr;
};

Child StartVictim(const std::filesystem::path& file, const char* limit,
                  const std::filesystem::path& errors) {
  int ends[2];
  PLB_CHECK(pipe(ends) == 0);
  const pid_t pid = fork();
  PLB_CHECK(pid >= 0);
  if (pid == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    if (freopen(errors.c_str(), "w", stderr) == nullptr) _exit(127);
    execl(PLUMBLINE_RUN_FILE_VICTIM, PLUMBLINE_RUN_FILE_VICTIM, file.c_str(), limit, nullptr);
    _exit(127);
  }
  close(ends[1]);
  return {pid, fdopen(ends[0], "r")};
}

/// Waits until the child has reported `frame`.
int WaitForFrame(const Child& child, int frame) {
  int last = 0;
  char line[32];
  while (last < frame && fgets(line, sizeof(line), child.output) != nullptr) last = std::stoi(line);
  return last;
}

/// The last complete line that the child printed (`last` if there is none); also waits for its end.
int LastReported(const Child& child, int last, int& status) {
  char line[32];
  while (fgets(line, sizeof(line), child.output) != nullptr) {
    if (std::string(line).back() == '\n') last = std::stoi(line);
  }
  fclose(child.output);
  waitpid(child.pid, &status, 0);
  return last;
}

TEST(RunFileKilled, KeepsEveryFrameReportedAsWritten) {
  Random random({.seed = 1});
  int total = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "run.plb";
    const Child child = StartVictim(file, nullptr, folder.path() / "errors.txt");
    const int waited = WaitForFrame(child, static_cast<int>(random.Index(50)));
    usleep(random.Index(20'000));
    kill(child.pid, SIGKILL);
    int status = 0;
    const int reported = LastReported(child, waited, status);
    ASSERT_TRUE(WIFSIGNALED(status));
    total += reported;
    if (reported == 0) continue;  // killed before the file was there
    const Result<std::unique_ptr<RunReader>> reader = RunReader::Open(file);
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    const int count = *(*reader)->NumFrames();
    ASSERT_GE(count, reported);
    for (int frame = 0; frame < count; ++frame) {
      const Result<FrameReport> report = (*reader)->ReadFrame(frame);
      ASSERT_TRUE(report.ok()) << report.error().message;
      ASSERT_EQ(Fingerprint(*report), Fingerprint(RandomFrame(5, frame, 3, 200)));
      ASSERT_FALSE((*reader)->ReadThumbnail(frame)->empty());
    }
    EXPECT_FALSE(*(*reader)->Finished());
    const Result<RunWriter::Resumed> resumed = RunWriter::OpenToResume(file, RandomHeader(1));
    ASSERT_TRUE(resumed.ok()) << resumed.error().message;
    EXPECT_EQ(resumed->last->frame, count - 1);
  }
  EXPECT_GT(total, 200);
  RecordProperty("frames_reported", total);
}

TEST(RunFileOnAFullDisk, SaysSoAndKeepsWhatWasWritten) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "run.plb";
  const Child child = StartVictim(file, "3000000", folder.path() / "errors.txt");
  int status = 0;
  const int written = LastReported(child, 0, status);
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_EQ(WEXITSTATUS(status), 3);
  std::ifstream errors(folder.path() / "errors.txt");
  std::string message;
  std::getline(errors, message);
  EXPECT_THAT(message, HasSubstr("run.plb"));
  EXPECT_THAT(message, HasSubstr("free some space and go on with --resume"));
  const Result<std::unique_ptr<RunReader>> reader = RunReader::Open(file);
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  EXPECT_GT(written, 5);
  EXPECT_EQ(*(*reader)->NumFrames(), written);
  EXPECT_TRUE((*reader)->ReadFrame(written - 1).ok());
}

std::string OpenError(const std::filesystem::path& file, ErrorCode code) {
  const Result<std::unique_ptr<RunReader>> reader = RunReader::Open(file);
  if (reader.ok()) return "it opened";
  EXPECT_EQ(reader.error().code, code);
  EXPECT_THAT(reader.error().message, HasSubstr(file.filename().string()));
  return reader.error().message;
}

void WriteSmallRun(const std::filesystem::path& file) {
  Result<std::unique_ptr<RunWriter>> writer = RunWriter::Create(file, RandomHeader(1));
  ASSERT_TRUE(writer.ok()) << writer.error().message;
  for (int frame = 0; frame < 10; ++frame)
    ASSERT_TRUE((*writer)->Write(RandomFrame(1, frame, 2, 50), {}).ok());
  ASSERT_TRUE((*writer)->Close().ok());
}

TEST(RunFileErrors, MissingFile) {
  const TemporaryFolder folder;
  EXPECT_THAT(OpenError(folder.path() / "none.plb", ErrorCode::kNotFound),
              HasSubstr("does not exist"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "none.plb"));
}

TEST(RunFileErrors, NotARunFile) {
  const TemporaryFolder folder;
  const auto text = folder.path() / "text.plb";
  std::ofstream(text) << std::string(10000, 'x');
  EXPECT_THAT(OpenError(text, ErrorCode::kInvalidInput), HasSubstr("is not a run file"));
  const auto empty = folder.path() / "empty.plb";
  std::ofstream(empty).flush();
  EXPECT_THAT(OpenError(empty, ErrorCode::kInvalidInput), HasSubstr("is not a run file"));
  const auto other = folder.path() / "other.plb";
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(other.c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database, "CREATE TABLE t (a)", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  EXPECT_THAT(OpenError(other, ErrorCode::kInvalidInput), HasSubstr("is not a run file"));
  EXPECT_THAT(OpenError(folder.path(), ErrorCode::kInvalidInput), HasSubstr("is not a run file"));
}

TEST(RunFileErrors, NewerVersion) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "run.plb";
  WriteSmallRun(file);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database, "PRAGMA user_version = 3", nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  EXPECT_THAT(OpenError(file, ErrorCode::kUnsupported), HasSubstr("newer Plumbline"));
  const auto resumed = RunWriter::OpenToResume(file, RandomHeader(1));
  ASSERT_FALSE(resumed.ok());
  EXPECT_EQ(resumed.error().code, ErrorCode::kUnsupported);
}

TEST(RunFileErrors, TruncatedAnywhereIsAnError) {
  const TemporaryFolder folder;
  const auto whole = folder.path() / "whole.plb";
  WriteSmallRun(whole);
  const auto size = std::filesystem::file_size(whole);
  for (int part = 1; part < 40; ++part) {
    const auto file = folder.path() / "cut.plb";
    std::filesystem::copy_file(whole, file, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(file, size * static_cast<unsigned>(part) / 40);
    const Result<std::unique_ptr<RunReader>> reader = RunReader::Open(file);
    ASSERT_FALSE(reader.ok()) << part;
    EXPECT_THAT(reader.error().message,
                testing::AnyOf(HasSubstr("truncated or damaged"), HasSubstr("is not a run")));
  }
}

TEST(RunFileErrors, DamagedBytesAreReportedByFrameOrFile) {
  const TemporaryFolder folder;
  const auto whole = folder.path() / "whole.plb";
  WriteSmallRun(whole);
  const auto size = std::filesystem::file_size(whole);
  Random random({.seed = 6});
  for (int trial = 0; trial < 100; ++trial) {
    const auto file = folder.path() / "damaged.plb";
    std::filesystem::copy_file(whole, file, std::filesystem::copy_options::overwrite_existing);
    {
      std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
      for (int i = 0; i < 20; ++i) {
        bytes.seekp(random.Index(static_cast<std::uint32_t>(size)));
        bytes.put(static_cast<char>(random.Bits()));
      }
    }
    const Result<std::unique_ptr<RunReader>> reader = RunReader::Open(file);
    if (!reader.ok()) continue;
    for (int position = 0; position < 10; ++position) {
      const Result<FrameReport> report = (*reader)->ReadFrame(position);
      EXPECT_TRUE(report.ok() || report.error().message.find("damaged.plb") != std::string::npos);
    }
    (void)(*reader)->Events();
    (void)(*reader)->ObjectTracks();
  }
}

TEST(RunFileErrors, AnObjectThatIsNowhereIsDamage) {
  ObjectReport object, read;
  object.world_from_object.setIdentity();
  ASSERT_TRUE(DecodeObject(EncodeObject(object), read).ok());
  object.world_from_object.translation().x() = std::nan("");
  const Status status = DecodeObject(EncodeObject(object), read);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kCorrupt);
}

TEST(RunFileErrors, AFolderThatIsNotThere) {
  const auto writer = RunWriter::Create("/proc/no/such/folder/run.plb", RandomHeader(1));
  ASSERT_FALSE(writer.ok());
  EXPECT_EQ(writer.error().code, ErrorCode::kIo);
  EXPECT_THAT(writer.error().message, HasSubstr("/proc/no/such/folder/run.plb"));
}

}  // namespace
}  // namespace plumbline
