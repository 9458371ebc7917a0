// SPDX-License-Identifier: Apache-2.0
#pragma once

// A thin wrapper of SQLite for the sources of this folder and of engine/batch; nobody else includes
// it.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "engine/base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace plumbline::sqlite {

enum class Access { kReadOnly, kReadWrite, kCreate };

class Statement;

/// One connection. Not safe to use from several threads at once.
class Database {
 public:
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// @param stands_for  The file that messages name, if `file` only stands in for it.
  /// Errors: kNotFound where the file cannot be opened, kIo otherwise.
  static Result<std::unique_ptr<Database>> Open(const std::filesystem::path& file, Access access,
                                                const std::filesystem::path& stands_for = {});
  /// For reading only, but also what a killed writer left unfinished: that is brought to an end in
  /// place or, where nothing may be written, in a private copy that goes with the connection.
  static Result<std::unique_ptr<Database>> OpenToRead(const std::filesystem::path& file);

  /// Runs statements that give no rows.
  Status Execute(const char* sql);
  Result<Statement> Prepare(const char* sql);
  /// The first column of the first row. Errors: kCorrupt if there is no row.
  Result<std::int64_t> QueryInteger(const char* sql);
  Result<std::string> QueryText(const char* sql);
  /// What went wrong last, as one sentence that starts with `what` and ends with what to do.
  Error LastError(std::string_view what) const;
  /// As messages name it.
  const std::filesystem::path& file() const { return file_; }
  /// Where it is.
  const std::filesystem::path& location() const { return location_; }

 private:
  Database(std::filesystem::path file, std::filesystem::path location)
      : file_(std::move(file)), location_(std::move(location)) {}
  bool NeedsRecovery();
  static bool Recover(const std::filesystem::path& file);

  struct Closer {
    void operator()(sqlite3* handle) const;
  };
  std::filesystem::path file_, location_;
  std::shared_ptr<const void> private_folder_;  ///< Before the connection: removed after it.
  std::unique_ptr<sqlite3, Closer> handle_;
};

/// A prepared statement of a database that outlives it. Parameters count from 1, columns from 0.
class Statement {
 public:
  void Bind(int parameter, std::int64_t value);
  void Bind(int parameter, double value);
  void BindText(int parameter, std::string_view text);
  void BindBlob(int parameter, std::string_view bytes);
  void BindNull(int parameter);

  /// True where there is a row to read; false at the end.
  Result<bool> Step();
  /// Steps to the end and makes the statement ready for the next use.
  Status Run();
  /// Ends the read transaction that a started statement holds; call it as soon as the rows are
  /// read.
  void Reset();

  bool IsNull(int column) const;
  std::int64_t Integer(int column) const;
  double Real(int column) const;
  /// Valid until the next Step or Reset.
  std::string_view Text(int column) const;
  std::string_view Blob(int column) const;

 private:
  friend class Database;
  struct Finalizer {
    void operator()(sqlite3_stmt* handle) const;
  };
  const Database* database_ = nullptr;
  std::unique_ptr<sqlite3_stmt, Finalizer> handle_;
};

}  // namespace plumbline::sqlite
