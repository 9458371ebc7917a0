// SPDX-License-Identifier: Apache-2.0
// A writer that ends, or whose disk fails, at each of its writes, one after the other.

#include <sqlite3.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <climits>
#include <functional>
#include <thread>

#include <gmock/gmock.h>

#include "engine/base/check.h"
#include "engine/recording/run_file.h"
#include "tests/engine/recording/random_run.h"
#include "tests/support/failing_vfs.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using std::filesystem::path;
namespace fs = std::filesystem;

constexpr int kFrames = 3;
constexpr std::uint64_t kOld = 1, kNew = 2;  // seeds of header and frames

FrameReport Frame(std::uint64_t run, int frame) { return RandomFrame(run, frame, 1, 20); }

/// What the parent knows of a child that may end at any moment.
struct Told {
  int num_written = 0;     ///< Frames that the writer reported as written.
  bool has_begun = false;  ///< Whether the writer was there.
  bool complete = false;   ///< Whether the child came to its end.
  int disk_changes = 0;
};

/// Ends with what `act` returns. Children share memory with nobody but through `told`.
int RunChild(const std::function<int()>& act) {
  const pid_t child = fork();
  PLB_CHECK(child >= 0);
  if (child == 0) _exit(act());
  int status = 0;
  waitpid(child, &status, 0);
  PLB_CHECK(WIFEXITED(status)) << "a child crashed";
  return WEXITSTATUS(status);
}

/// Writes the frames up to kFrames and closes. Unless the disk fails, it waits for each frame.
bool WriteOn(RunWriter& writer, std::uint64_t run, bool disk_fails, Told& told) {
  told.num_written = writer.num_written();
  told.has_begun = true;
  for (int frame = writer.num_written(); frame < kFrames; ++frame) {
    if (!writer.Write(Frame(run, frame), {}).ok()) break;
    while (!disk_fails && writer.num_written() <= frame) usleep(20);
    told.num_written = writer.num_written();
  }
  const bool closed = writer.Close().ok();
  told.num_written = writer.num_written();
  return closed;
}

bool Create(const path& file, std::uint64_t run, int past, bool disk_fails, Told& told) {
  const auto write_past = [&](RunWriter& writer) -> Status {
    for (int frame = 0; frame < past; ++frame) {
      if (Status status = writer.Write(Frame(run, frame), {}); !status.ok()) return status;
    }
    return {};
  };
  auto writer = RunWriter::Create(file, RandomHeader(run), write_past);
  return writer.ok() && WriteOn(**writer, run, disk_fails, told);
}

bool Resume(const path& file, std::uint64_t run, bool disk_fails, Told& told) {
  auto resumed = RunWriter::OpenToResume(file, RandomHeader(run));
  return resumed.ok() && WriteOn(*resumed->writer, run, disk_fails, told);
}

void WriteWholeRun(const path& file, std::uint64_t run, int frames) {
  auto writer = RunWriter::Create(file, RandomHeader(run)).value();
  for (int frame = 0; frame < frames; ++frame) {
    PLB_CHECK(writer->Write(Frame(run, frame), {}).ok());
  }
  PLB_CHECK(writer->Close().ok());
}

/// A run that a kill left with its frames in the log.
void WriteCutOffRun(const path& file, std::uint64_t run, int frames) {
  const int code = RunChild([&] {
    RunWriter* writer = RunWriter::Create(file, RandomHeader(run)).value().release();
    for (int frame = 0; frame < frames; ++frame) (void)writer->Write(Frame(run, frame), {});
    while (writer->num_written() < frames) usleep(100);
    return 0;
  });
  PLB_CHECK(code == 0 && fs::file_size(file.string() + "-wal") > 0);
}

/// Whether the frames are those of `run`, one after the other. -1 if not, or if it cannot be read.
int CountFrames(const path& file, std::uint64_t run, std::string& why) {
  const auto reader = RunReader::Open(file);
  why = reader.ok() ? "frames differ" : reader.error().message;
  if (!reader.ok()) return -1;
  if (HeaderToJson((*reader)->header()) != HeaderToJson(RandomHeader(run))) return -1;
  const Result<int> frames = (*reader)->NumFrames();
  for (int frame = 0; frames.ok() && frame < *frames; ++frame) {
    const Result<FrameReport> report = (*reader)->ReadFrame(frame);
    if (!report.ok() || Fingerprint(*report) != Fingerprint(Frame(run, frame))) return -1;
  }
  return frames.ok() ? *frames : -1;
}

/// The same for somebody who may read the folder only: in a thread of its own, since Linux gives
/// each thread its own user.
int CountFramesReadOnly(const path& file, std::uint64_t run) {
  fs::permissions(file.parent_path(), fs::perms(0555));
  int frames = -1;
  std::string why;
  std::thread([&] {
    // The C library's functions would change the user of the whole process, for good.
    PLB_CHECK(geteuid() != 0 || (syscall(SYS_setresgid, 65534, 65534, 65534) == 0 &&
                                 syscall(SYS_setresuid, 65534, 65534, 65534) == 0));
    frames = CountFrames(file, run, why);
  }).join();
  fs::permissions(file.parent_path(), fs::perms(0755));
  EXPECT_GE(frames, 0) << why;
  return frames;
}

struct Scenario {
  const char* name;
  std::function<void(const path& file)> prepare;
  std::function<bool(const path& file, bool disk_fails, Told& told)> act;
  bool is_resumed = false;  ///< The run that is there is continued, not replaced.
  bool has_old = false;     ///< There is a run of seed kOld with kFrames frames.
};

void PrintTo(const Scenario& scenario, std::ostream* out) { *out << scenario.name; }

class RunFileKilledAtEveryWrite : public testing::TestWithParam<Scenario> {
 protected:
  RunFileKilledAtEveryWrite() {
    InstallFailingVfs(DiskFailure::kEndBefore, INT_MAX);
    fs::permissions(folder_.path(), fs::perms(0755));
    fs::create_directory(folder_.path() / "template");
    GetParam().prepare(folder_.path() / "template" / "run.plb");
    void* memory =
        mmap(nullptr, sizeof(Told), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    PLB_CHECK(memory != MAP_FAILED);
    told_ = new (memory) Told;
  }
  ~RunFileKilledAtEveryWrite() override { munmap(told_, sizeof(Told)); }

  path file() const { return folder_.path() / "now" / "run.plb"; }

  void Run(DiskFailure failure, int at) {
    fs::remove_all(folder_.path() / "now");
    fs::copy(folder_.path() / "template", folder_.path() / "now", fs::copy_options::recursive);
    *told_ = {};
    const int code = RunChild([&] {
      InstallFailingVfs(failure, at);
      told_->complete = GetParam().act(file(), failure == DiskFailure::kFailFromThen, *told_);
      told_->disk_changes = NumDiskChanges();
      return 0;
    });
    ASSERT_TRUE(code == 0 || code == kEndedByVfs) << code;
    // What fails while the log is folded into the file does no harm.
    if (failure != DiskFailure::kFailFromThen) {
      ASSERT_EQ(code == 0, told_->complete);
    }
  }

  /// Every frame that was reported is there, and the run can be continued.
  void Check() {
    if (!fs::exists(file())) {
      EXPECT_FALSE(told_->has_begun);
      EXPECT_FALSE(GetParam().has_old || GetParam().is_resumed);
      WriteWholeRun(file(), kNew, kFrames);  // what is left behind hinders nobody
      return;
    }
    std::string why;
    const bool old = GetParam().has_old && CountFrames(Copy(), kOld, why) >= 0;
    const std::uint64_t run = old ? kOld : kNew;
    if (old) {
      EXPECT_FALSE(told_->has_begun) << "an old run in place of the new one";
    }
    const int least = old ? kFrames : told_->num_written;
    const int read_only = CountFramesReadOnly(file(), run);
    EXPECT_GE(read_only, least);
    EXPECT_LE(read_only, kFrames);
    const int count = CountFrames(file(), run, why);
    EXPECT_EQ(count, read_only) << why;
    const auto resumed = RunWriter::OpenToResume(file(), RandomHeader(run));
    ASSERT_TRUE(resumed.ok()) << resumed.error().message;
    ASSERT_EQ(resumed->writer->num_written(), count);
    for (int frame = count; frame <= kFrames; ++frame) {
      ASSERT_TRUE(resumed->writer->Write(Frame(run, frame), {}).ok());
    }
    ASSERT_TRUE(resumed->writer->Close().ok());
    EXPECT_EQ(CountFramesReadOnly(file(), run), kFrames + 1);
  }

  /// To look at without an effect on the files.
  path Copy() {
    fs::remove_all(folder_.path() / "copy");
    fs::copy(folder_.path() / "now", folder_.path() / "copy", fs::copy_options::recursive);
    return folder_.path() / "copy" / "run.plb";
  }

  TemporaryFolder folder_;
  Told* told_ = nullptr;
};

TEST_P(RunFileKilledAtEveryWrite, ItHoldsWhatWasReportedAndGoesOn) {
  Run(DiskFailure::kEndBefore, INT_MAX);
  ASSERT_TRUE(told_->complete);
  ASSERT_EQ(told_->num_written, kFrames);
  const int changes = told_->disk_changes;
  ASSERT_GT(changes, 10);
  for (const DiskFailure failure : {DiskFailure::kEndBefore, DiskFailure::kEndHalfWay,
                                    DiskFailure::kEndAfter, DiskFailure::kFailFromThen}) {
    for (int at = 1; at <= changes; ++at) {
      SCOPED_TRACE("failure " + std::to_string(static_cast<int>(failure)) + " at change " +
                   std::to_string(at) + " of " + std::to_string(changes));
      Run(failure, at);
      Check();
      if (HasFailure()) return;
    }
  }
  RecordProperty("disk_changes", changes);
}

const Scenario kScenarios[] = {
    {.name = "Created",
     .prepare = [](const path&) {},
     .act = [](const path& file, bool fails,
               Told& told) { return Create(file, kNew, 0, fails, told); }},
    {.name = "Forked",
     .prepare = [](const path&) {},
     .act = [](const path& file, bool fails,
               Told& told) { return Create(file, kNew, 2, fails, told); }},
    {.name = "InPlaceOfARunThatWasCutOff",
     .prepare = [](const path& file) { WriteCutOffRun(file, kOld, kFrames); },
     .act = [](const path& file, bool fails,
               Told& told) { return Create(file, kNew, 0, fails, told); },
     .has_old = true},
    {.name = "ResumedAfterItsEnd",
     .prepare = [](const path& file) { WriteWholeRun(file, kNew, 2); },
     .act = [](const path& file, bool fails,
               Told& told) { return Resume(file, kNew, fails, told); },
     .is_resumed = true},
    {.name = "ResumedAfterAKill",
     .prepare = [](const path& file) { WriteCutOffRun(file, kNew, 2); },
     .act = [](const path& file, bool fails,
               Told& told) { return Resume(file, kNew, fails, told); },
     .is_resumed = true}};
INSTANTIATE_TEST_SUITE_P(, RunFileKilledAtEveryWrite, testing::ValuesIn(kScenarios),
                         [](const auto& scenario) { return scenario.param.name; });

/// Leaves `file` as a program does that is killed while it switches to one file with a rollback
/// journal, as Plumbline 0.3 did.
void LeaveHotJournal(const path& file) {
  const path other = file.string() + "-other";
  for (int at = 1;; ++at) {
    fs::copy_file(file, other, fs::copy_options::overwrite_existing);
    RunChild([&] {
      InstallFailingVfs(DiskFailure::kEndAfter, at);
      sqlite3* database = nullptr;
      sqlite3_open(other.c_str(), &database);
      sqlite3_exec(database, "PRAGMA application_id = 0x504C4252; UPDATE run SET value = '1'",
                   nullptr, nullptr, nullptr);
      return 0;
    });
    sqlite3* database = nullptr;
    sqlite3_open_v2(other.c_str(), &database, SQLITE_OPEN_READONLY, nullptr);
    const int code = sqlite3_exec(database, "PRAGMA schema_version", nullptr, nullptr, nullptr);
    sqlite3_close(database);
    ASSERT_LT(at, 50) << "no hot journal was left";
    if (code == SQLITE_READONLY) break;
    fs::remove(other.string() + "-journal");
  }
  fs::rename(other, file);
  fs::rename(other.string() + "-journal", file.string() + "-journal");
}

TEST(RunFileWithAHotJournal, IsRecovered) {
  const TemporaryFolder folder;
  fs::permissions(folder.path(), fs::perms(0755));
  fs::create_directory(folder.path() / "sub");
  const path file = folder.path() / "sub" / "run.plb";
  WriteWholeRun(file, kNew, kFrames);
  LeaveHotJournal(file);
  EXPECT_EQ(CountFramesReadOnly(file, kNew), kFrames);
  EXPECT_TRUE(fs::exists(file.string() + "-journal")) << "who may only read changes nothing";
  std::string why;
  EXPECT_EQ(CountFrames(file, kNew, why), kFrames) << why;
  LeaveHotJournal(file);
  EXPECT_TRUE(RunWriter::OpenToResume(file, RandomHeader(kNew)).ok());
}

TEST(RunFileLock, ASecondWriterIsTurnedAwayAndNothingIsLost) {
  const TemporaryFolder folder;
  const path file = folder.path() / "run.plb";
  auto first = RunWriter::Create(file, RandomHeader(kNew)).value();
  ASSERT_TRUE(first->Write(Frame(kNew, 0), {}).ok());
  const auto message = [&](const auto& second) {
    return second.ok() ? std::string("it is written twice") : second.error().message;
  };
  using testing::HasSubstr;
  EXPECT_THAT(message(RunWriter::Create(file, RandomHeader(kOld))),
              testing::AllOf(HasSubstr("run.plb' is open in another window or command (process"),
                             HasSubstr("choose another file")));
  EXPECT_THAT(message(RunWriter::OpenToResume(file, RandomHeader(kNew))), HasSubstr("is open in"));
  ASSERT_TRUE(first->Close().ok());
  std::string why;
  EXPECT_EQ(CountFrames(file, kNew, why), 1) << why;
  EXPECT_TRUE(RunWriter::OpenToResume(file, RandomHeader(kNew)).ok());
  EXPECT_FALSE(fs::exists(file.string() + ".lock"));
}

TEST(RunFileReplaced, TheOldRunStaysUntilTheNewOneHasItsPast) {
  const TemporaryFolder folder;
  const path file = folder.path() / "run.plb";
  WriteWholeRun(file, kOld, kFrames);
  std::string why;
  const auto refused = RunWriter::Create(file, RandomHeader(kNew), [&](RunWriter& past) -> Status {
    EXPECT_TRUE(past.Write(Frame(kNew, 0), {}).ok());
    EXPECT_EQ(CountFrames(file, kOld, why), kFrames) << why;
    return Error{ErrorCode::kInvalidInput, "another sequence"};
  });
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message, "another sequence");
  EXPECT_EQ(CountFrames(file, kOld, why), kFrames) << why;
  int files = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder.path())) ++files;
  EXPECT_EQ(files, 1) << "nothing stays beside";
}

}  // namespace
}  // namespace plumbline
