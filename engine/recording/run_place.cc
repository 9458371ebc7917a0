// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/run_place.h"

#include "engine/base/files.h"
#include "engine/recording/run_schema.h"

namespace plumbline {
namespace {

Status RemoveFile(const std::string& file) {
  std::error_code error;
  std::filesystem::remove(file, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, "cannot replace " + file + ": " + error.message()};
}

Status RemoveCompanions(const std::filesystem::path& file) {
  for (const char* suffix : {"-wal", "-shm", "-journal"}) {
    if (const Status removed = RemoveFile(file.string() + suffix); !removed.ok()) return removed;
  }
  return {};
}

}  // namespace

std::filesystem::path PlaceBeside(const std::filesystem::path& file) {
  return file.string() + ".new";
}

Status RemoveRun(const std::filesystem::path& file) {
  if (const Status removed = RemoveFile(file.string()); !removed.ok()) return removed;
  return RemoveCompanions(file);
}

Status CheckReplaceable(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return {};
  if (std::filesystem::file_size(file, error) == 0 && !error) return {};
  const auto old = sqlite::Database::OpenToRead(file);
  const auto id =
      old ? (*old)->QueryInteger("PRAGMA application_id") : Result<std::int64_t>(old.error());
  if (id && *id == kRunApplicationId) return {};
  // One that was killed when it began, once rolled back.
  const auto pages = id ? (*old)->QueryInteger("PRAGMA page_count") : id;
  if (pages && *pages == 0) return {};
  return Error{
      ErrorCode::kInvalidInput,
      file.string() + " exists and is not a run file; choose another name " + "or remove it first"};
}

Status PutInPlace(const std::filesystem::path& beside, const std::filesystem::path& file) {
  // First all of the old run goes into its one file, so that its companions can go: beside the new
  // file they would damage it.
  std::error_code error;
  if (std::filesystem::exists(file, error)) {
    if (auto old = sqlite::Database::Open(file, sqlite::Access::kReadWrite); old.ok()) {
      (void)(*old)->Execute("PRAGMA wal_checkpoint(TRUNCATE)");
    }
  }
  for (const std::filesystem::path& place : {beside, file}) {
    if (const Status removed = RemoveCompanions(place); !removed.ok()) return removed;
  }
  std::filesystem::rename(beside, file, error);
  if (error) {
    return Error{ErrorCode::kIo, "cannot replace " + file.string() + ": " + error.message()};
  }
  SyncFolderOf(file);
  return {};
}

// The switch from one file to file and log and back rewrites one page, in which only a few bytes
// of its first sector change. SQLite would keep a rollback journal of that in a file; a kill
// between the two would leave it to readers, who may not be allowed to roll anything back.

Status UseWriteAheadLog(sqlite::Database& database) {
  Result<std::string> mode = database.QueryText("PRAGMA journal_mode");
  if (mode && *mode != "wal") {
    if (const Status off = database.Execute("PRAGMA journal_mode = OFF"); !off.ok()) return off;
    mode = database.QueryText("PRAGMA journal_mode = WAL");
  }
  if (!mode) return mode.error();
  if (*mode != "wal") {
    return Error{ErrorCode::kIo, "cannot write " + database.file().string() +
                                     ": the file system keeps no log beside it; choose another "
                                     "folder"};
  }
  return database.Execute("PRAGMA synchronous = NORMAL");
}

Status FoldLog(sqlite::Database& database) {
  (void)database.Execute("PRAGMA busy_timeout = 0; PRAGMA wal_checkpoint(TRUNCATE);");
  const Result<std::string> mode = database.QueryText("PRAGMA journal_mode = MEMORY");
  if (!mode) return mode.error();
  if (*mode == "memory") return {};
  return Error{ErrorCode::kIo, database.file().string() + " is being read; its log stays"};
}

}  // namespace plumbline
