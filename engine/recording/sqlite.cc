// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/sqlite.h"

#include <sqlite3.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/base/file_lock.h"

namespace plumbline::sqlite {

namespace {

/// A fresh folder that is removed with all it holds.
class PrivateFolder {
 public:
  static Result<std::shared_ptr<const PrivateFolder>> Create() {
    std::error_code error;
    std::string name =
        (std::filesystem::temp_directory_path(error) / "plumbline_copy_XXXXXX").string();
    if (error || ::mkdtemp(name.data()) == nullptr) {
      return Error{ErrorCode::kIo, "cannot make a temporary folder '" + name + "'"};
    }
    return std::shared_ptr<const PrivateFolder>(new PrivateFolder(name));
  }
  ~PrivateFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit PrivateFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

/// A log that no writer attends to, with an index that may not be written: SQLite would try for ten
/// seconds and give up.
bool HasUnattendedLog(const std::filesystem::path& file) {
  std::error_code error;
  const std::string index = file.string() + "-shm";
  return std::filesystem::exists(index, error) && ::access(index.c_str(), W_OK) != 0 &&
         !FileLock::IsHeld(file);
}

}  // namespace

void Database::Closer::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
void Statement::Finalizer::operator()(sqlite3_stmt* handle) const { sqlite3_finalize(handle); }

Result<std::unique_ptr<Database>> Database::Open(const std::filesystem::path& file, Access access,
                                                 const std::filesystem::path& stands_for) {
  int flags = SQLITE_OPEN_NOMUTEX;
  if (access == Access::kReadOnly) flags |= SQLITE_OPEN_READONLY;
  if (access == Access::kReadWrite) flags |= SQLITE_OPEN_READWRITE;
  if (access == Access::kCreate) flags |= SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  sqlite3* handle = nullptr;
  const int code = sqlite3_open_v2(file.c_str(), &handle, flags, nullptr);
  std::unique_ptr<Database> database(new Database(stands_for.empty() ? file : stands_for, file));
  database->handle_.reset(handle);
  if (code != SQLITE_OK) return database->LastError("cannot open");
  sqlite3_busy_timeout(handle, 5000);
  return database;
}

/// Whether reading fails only because something unfinished would have to be written first.
bool Database::NeedsRecovery() {
  const int code =
      sqlite3_exec(handle_.get(), "PRAGMA schema_version", nullptr, nullptr, nullptr) & 0xff;
  return code == SQLITE_READONLY || code == SQLITE_CANTOPEN || code == SQLITE_PROTOCOL;
}

/// Lets SQLite bring to an end in place what a killed writer began.
bool Database::Recover(const std::filesystem::path& file) {
  const auto database = Open(file, Access::kReadWrite);
  return database.ok() && !(*database)->NeedsRecovery();
}

Result<std::unique_ptr<Database>> Database::OpenToRead(const std::filesystem::path& file) {
  auto database = Open(file, Access::kReadOnly);
  if (!database) return database;
  const bool stuck = HasUnattendedLog(file);
  if (!stuck && !(*database)->NeedsRecovery()) return database;
  if (!stuck && Recover(file)) {
    database = Open(file, Access::kReadOnly);
    if (!database || !(*database)->NeedsRecovery()) return database;
  }
  auto folder = PrivateFolder::Create();
  if (!folder) return folder.error();
  const std::filesystem::path copy = (*folder)->path() / "copy.plb";
  for (const char* suffix : {"", "-wal", "-journal"}) {
    std::error_code error;
    const std::filesystem::path part = file.string() + suffix;
    if (!std::filesystem::exists(part, error)) continue;
    if (!std::filesystem::copy_file(part, copy.string() + suffix, error)) {
      return Error{ErrorCode::kIo, "cannot copy " + part.string() + " to '" +
                                       (*folder)->path().string() +
                                       "' to read it: " + error.message()};
    }
    std::filesystem::permissions(copy.string() + suffix, std::filesystem::perms::owner_write,
                                 std::filesystem::perm_options::add, error);
  }
  database = Open(copy, Access::kReadWrite, file);
  if (database) (*database)->private_folder_ = std::move(*folder);
  return database;
}

Error Database::LastError(std::string_view what) const {
  const int code = handle_ ? sqlite3_errcode(handle_.get()) : SQLITE_NOMEM;
  const std::string start = std::string(what) + " " + file_.string() + ": ";
  const std::string reason = handle_ ? sqlite3_errmsg(handle_.get()) : "out of memory";
  switch (code) {
    case SQLITE_NOTADB:
      return {ErrorCode::kInvalidInput,
              file_.string() + " is not a run file of Plumbline; choose a .plb"};
    case SQLITE_CORRUPT:
      return {ErrorCode::kCorrupt,
              file_.string() + " is truncated or damaged (" + reason +
                  "); copy it again together with its -wal file, or repeat the run"};
    case SQLITE_CANTOPEN:
      return {ErrorCode::kNotFound,
              start + "no such file, or a folder without permission; check the path"};
    case SQLITE_READONLY:
      return {ErrorCode::kIo, start + "it cannot be written there; choose another folder"};
    case SQLITE_FULL:
    case SQLITE_IOERR:
      return {ErrorCode::kIo, start + reason + "; free some space and go on with --resume"};
    case SQLITE_BUSY:
      return {ErrorCode::kIo,
              start + "another program is writing it; wait for that or choose another file"};
    default:
      return {ErrorCode::kIo, start + reason};
  }
}

Status Database::Execute(const char* sql) {
  if (sqlite3_exec(handle_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) {
    return LastError("cannot use");
  }
  return {};
}

Result<Statement> Database::Prepare(const char* sql) {
  sqlite3_stmt* handle = nullptr;
  if (sqlite3_prepare_v3(handle_.get(), sql, -1, SQLITE_PREPARE_PERSISTENT, &handle, nullptr) !=
      SQLITE_OK) {
    return LastError("cannot use");
  }
  Statement statement;
  statement.database_ = this;
  statement.handle_.reset(handle);
  return statement;
}

Result<std::int64_t> Database::QueryInteger(const char* sql) {
  Result<Statement> statement = Prepare(sql);
  if (!statement) return statement.error();
  const Result<bool> row = statement->Step();
  if (!row) return row.error();
  if (!*row)
    return Error{ErrorCode::kCorrupt,
                 file_.string() + " lacks a table of its format; repeat the run"};
  return statement->Integer(0);
}

Result<std::string> Database::QueryText(const char* sql) {
  Result<Statement> statement = Prepare(sql);
  if (!statement) return statement.error();
  const Result<bool> row = statement->Step();
  if (!row) return row.error();
  if (!*row) return std::string();
  return std::string(statement->Text(0));
}

void Statement::Bind(int parameter, std::int64_t value) {
  sqlite3_bind_int64(handle_.get(), parameter, value);
}
void Statement::Bind(int parameter, double value) {
  sqlite3_bind_double(handle_.get(), parameter, value);
}
void Statement::BindText(int parameter, std::string_view text) {
  sqlite3_bind_text(handle_.get(), parameter, text.data(), static_cast<int>(text.size()),
                    SQLITE_TRANSIENT);
}
void Statement::BindBlob(int parameter, std::string_view bytes) {
  // A null pointer would store NULL where an empty blob is meant.
  sqlite3_bind_blob(handle_.get(), parameter, bytes.empty() ? "" : bytes.data(),
                    static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
}
void Statement::BindNull(int parameter) { sqlite3_bind_null(handle_.get(), parameter); }

Result<bool> Statement::Step() {
  const int code = sqlite3_step(handle_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  Error error = database_->LastError("cannot use");
  Reset();
  return error;
}

Status Statement::Run() {
  while (true) {
    const Result<bool> row = Step();
    if (!row) return row.error();
    if (!*row) break;
  }
  Reset();
  return {};
}

void Statement::Reset() { sqlite3_reset(handle_.get()); }

bool Statement::IsNull(int column) const {
  return sqlite3_column_type(handle_.get(), column) == SQLITE_NULL;
}
std::int64_t Statement::Integer(int column) const {
  return sqlite3_column_int64(handle_.get(), column);
}
double Statement::Real(int column) const { return sqlite3_column_double(handle_.get(), column); }
std::string_view Statement::Text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(handle_.get(), column));
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column))};
}
std::string_view Statement::Blob(int column) const {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(handle_.get(), column));
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column))};
}

}  // namespace plumbline::sqlite
