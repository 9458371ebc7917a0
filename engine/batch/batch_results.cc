// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_results.h"

#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/batch/batch_figures.h"
#include "engine/recording/sqlite.h"

namespace plumbline {
namespace {

using nlohmann::json;

constexpr int kBatchApplicationId = 0x504C4242;  // "PLBB", in SQLite's header
constexpr int kBatchFormatVersion = 1;

constexpr const char* kBatchSchema = R"(
PRAGMA application_id = 0x504C4242;
PRAGMA user_version = 1;
CREATE TABLE batch (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE missed (
  run INTEGER NOT NULL,
  ordinal INTEGER NOT NULL,
  truth TEXT NOT NULL,
  model TEXT NOT NULL,
  cause TEXT NOT NULL,
  text TEXT NOT NULL,
  PRIMARY KEY (run, ordinal)) WITHOUT ROWID;
CREATE TABLE provenance (
  run INTEGER PRIMARY KEY,
  folder TEXT NOT NULL,
  reason TEXT NOT NULL,
  host TEXT NOT NULL,
  started TEXT NOT NULL,
  program_version TEXT NOT NULL,
  program_hash TEXT NOT NULL,
  frames INTEGER NOT NULL,
  run_s REAL NOT NULL,
  evaluate_s REAL NOT NULL);
)";

/// A name as SQL takes any. Not in double quotes, in which SQLite takes a column that is not there
/// for a text.
std::string Quoted(const std::string& name) {
  std::string quoted = "`";
  for (const char c : name) quoted += c == '`' ? std::string("``") : std::string(1, c);
  return quoted + "`";
}

/// run, sequence, recipe, set_OPTION.., seed, status, FIGURE..
std::string ResultColumns(const BatchTable& table, bool types) {
  std::string columns =
      types ? "run INTEGER PRIMARY KEY, sequence TEXT NOT NULL, recipe TEXT NOT NULL"
            : "run, sequence, recipe";
  for (const std::string& option : table.options)
    columns += ", " + Quoted("set_" + option) + (types ? " REAL NOT NULL" : "");
  columns += types ? ", seed INTEGER NOT NULL, status TEXT NOT NULL" : ", seed, status";
  for (const BatchFigure& figure : table.figures)
    columns += ", " + Quoted(figure.name) + (types ? " REAL" : "");
  return columns;
}

Status WriteRuns(sqlite::Database& database, const BatchTable& table) {
  const std::size_t count = 5 + table.options.size() + table.figures.size();
  std::string marks = "?";
  for (std::size_t i = 1; i < count; ++i) marks += ",?";
  auto insert = database.Prepare(
      fmt::format("INSERT INTO results ({}) VALUES ({})", ResultColumns(table, false), marks)
          .c_str());
  if (!insert.ok()) return insert.error();
  for (const BatchRun& run : table.runs) {
    int at = 0;
    insert->Bind(++at, std::int64_t{run.number});
    insert->BindText(++at, run.sequence);
    insert->BindText(++at, run.recipe);
    for (const double value : run.point) insert->Bind(++at, value);
    insert->Bind(++at, static_cast<std::int64_t>(run.seed));
    insert->BindText(++at, run.status);
    for (const auto& figure : run.figures) {
      if (figure)
        insert->Bind(++at, *figure);
      else
        insert->BindNull(++at);
    }
    if (Status status = insert->Run(); !status.ok()) return status;
  }
  return {};
}

Status WriteMissed(sqlite::Database& database, const BatchTable& table) {
  auto insert = database.Prepare("INSERT INTO missed VALUES (?,?,?,?,?,?)");
  if (!insert.ok()) return insert.error();
  for (const BatchRun& run : table.runs) {
    std::int64_t ordinal = 0;
    for (const BatchMiss& miss : run.missed) {
      insert->Bind(1, std::int64_t{run.number});
      insert->Bind(2, ordinal++);
      insert->BindText(3, miss.truth);
      insert->BindText(4, miss.model);
      insert->BindText(5, miss.cause);
      insert->BindText(6, miss.text);
      if (Status status = insert->Run(); !status.ok()) return status;
    }
  }
  return {};
}

Status WriteProvenance(sqlite::Database& database, const BatchTable& table) {
  auto insert = database.Prepare("INSERT INTO provenance VALUES (?,?,?,?,?,?,?,?,?,?)");
  if (!insert.ok()) return insert.error();
  for (const BatchRun& run : table.runs) {
    insert->Bind(1, std::int64_t{run.number});
    insert->BindText(2, run.folder);
    insert->BindText(3, run.reason);
    insert->BindText(4, run.host);
    insert->BindText(5, run.started);
    insert->BindText(6, run.program_version);
    insert->BindText(7, run.program_hash);
    insert->Bind(8, std::int64_t{run.frames});
    insert->Bind(9, run.run_s);
    insert->Bind(10, run.evaluate_s);
    if (Status status = insert->Run(); !status.ok()) return status;
  }
  return {};
}

json HeadOf(const BatchTable& table) {
  json figures = json::array();
  for (const BatchFigure& figure : table.figures) {
    figures.push_back({{"name", figure.name},
                       {"unit", figure.unit},
                       {"help", figure.help},
                       {"better", figure.better}});
  }
  return {{"name", table.name},
          {"sequences", table.sequences},
          {"recipes", table.recipes},
          {"options", table.options},
          {"figures", figures}};
}

Status WriteTables(const std::filesystem::path& file, const BatchTable& table) {
  auto database = sqlite::Database::Open(file, sqlite::Access::kCreate);
  if (!database.ok()) return database.error();
  sqlite::Database& to = **database;
  if (Status status = to.Execute("BEGIN"); !status.ok()) return status;
  if (Status status = to.Execute(kBatchSchema); !status.ok()) return status;
  const std::string create = "CREATE TABLE results (" + ResultColumns(table, true) + ")";
  if (Status status = to.Execute(create.c_str()); !status.ok()) return status;
  auto insert = to.Prepare("INSERT INTO batch VALUES ('head', ?)");
  if (!insert.ok()) return insert.error();
  insert->BindText(1, JsonText(HeadOf(table)));
  if (Status status = insert->Run(); !status.ok()) return status;
  if (Status status = WriteRuns(to, table); !status.ok()) return status;
  if (Status status = WriteMissed(to, table); !status.ok()) return status;
  if (Status status = WriteProvenance(to, table); !status.ok()) return status;
  return to.Execute("COMMIT");
}

/// Reads the rows of one results file.
class ResultsReader {
 public:
  explicit ResultsReader(sqlite::Database& database) : database_(database) {}

  Result<BatchTable> Read() {
    if (Status status = ReadHead(); !status.ok()) return status.error();
    if (Status status = ReadRuns(); !status.ok()) return status.error();
    if (Status status = ReadMissed(); !status.ok()) return status.error();
    if (Status status = ReadProvenance(); !status.ok()) return status.error();
    return std::move(table_);
  }

 private:
  Error Damaged(const std::string& what) const {
    return {ErrorCode::kCorrupt, "'" + database_.file().string() + "' is damaged: " + what +
                                     "; 'plumbline batch --out' of its folder makes it again"};
  }

  Status ReadHead() {
    const auto text = database_.QueryText("SELECT value FROM batch WHERE key = 'head'");
    if (!text.ok()) return text.error();
    const json head = ParseJson(*text);
    try {
      table_.name = head.at("name").get<std::string>();
      table_.sequences = head.at("sequences").get<std::vector<std::string>>();
      table_.recipes = head.at("recipes").get<std::vector<std::string>>();
      table_.options = head.at("options").get<std::vector<std::string>>();
      for (const json& figure : head.at("figures")) {
        table_.figures.push_back(
            {figure.at("name").get<std::string>(), figure.at("unit").get<std::string>(),
             figure.at("help").get<std::string>(), IntFromJson(figure.at("better"))});
      }
    } catch (const std::exception&) {
      return Damaged("its head is none");
    }
    return {};
  }

  Status ReadRuns() {
    const std::string select =
        "SELECT " + ResultColumns(table_, false) + " FROM results ORDER BY run";
    auto rows = database_.Prepare(select.c_str());
    if (!rows.ok()) return rows.error();
    for (;;) {
      const Result<bool> row = rows->Step();
      if (!row.ok()) return row.error();
      if (!*row) return {};
      BatchRun run;
      int at = 0;
      run.number = static_cast<int>(rows->Integer(at++));
      run.sequence = rows->Text(at++);
      run.recipe = rows->Text(at++);
      for (std::size_t i = 0; i < table_.options.size(); ++i) run.point.push_back(rows->Real(at++));
      run.seed = static_cast<std::uint64_t>(rows->Integer(at++));
      run.status = rows->Text(at++);
      for (std::size_t i = 0; i < table_.figures.size(); ++i, ++at) {
        const bool none = rows->IsNull(at) || !std::isfinite(rows->Real(at));
        run.figures.push_back(none ? std::nullopt : std::optional(rows->Real(at)));
      }
      places_[run.number] = table_.runs.size();
      table_.runs.push_back(std::move(run));
    }
  }

  BatchRun* RunOf(const sqlite::Statement& rows) {
    const auto found = places_.find(static_cast<int>(rows.Integer(0)));
    return found == places_.end() ? nullptr : &table_.runs[found->second];
  }

  Status ReadMissed() {
    auto rows = database_.Prepare(
        "SELECT run, truth, model, cause, text FROM missed ORDER BY run, ordinal");
    if (!rows.ok()) return rows.error();
    for (;;) {
      const Result<bool> row = rows->Step();
      if (!row.ok()) return row.error();
      if (!*row) return {};
      BatchRun* run = RunOf(*rows);
      if (run == nullptr) return Damaged("it has what a run missed, and not the run");
      run->missed.push_back({std::string(rows->Text(1)), std::string(rows->Text(2)),
                             std::string(rows->Text(3)), std::string(rows->Text(4))});
    }
  }

  Status ReadProvenance() {
    auto rows = database_.Prepare(
        "SELECT run, folder, reason, host, started, program_version, program_hash, frames, run_s, "
        "evaluate_s FROM provenance");
    if (!rows.ok()) return rows.error();
    for (;;) {
      const Result<bool> row = rows->Step();
      if (!row.ok()) return row.error();
      if (!*row) return {};
      BatchRun* run = RunOf(*rows);
      if (run == nullptr) return Damaged("it knows how a run was made, and not the run");
      run->folder = rows->Text(1);
      run->reason = rows->Text(2);
      run->host = rows->Text(3);
      run->started = rows->Text(4);
      run->program_version = rows->Text(5);
      run->program_hash = rows->Text(6);
      run->frames = static_cast<int>(rows->Integer(7));
      run->run_s = rows->Real(8);
      run->evaluate_s = rows->Real(9);
    }
  }

  sqlite::Database& database_;
  BatchTable table_;
  std::map<int, std::size_t> places_;
};

/// Messages of the wrapper are about run files.
Error OfResults(const std::filesystem::path& file, const Error& error) {
  if (error.code != ErrorCode::kInvalidInput) return error;
  return {error.code, "'" + file.string() +
                          "' holds no results of a batch; name the folder of a "
                          "batch or its results.sqlite"};
}

}  // namespace

Status WriteBatchResults(const std::filesystem::path& file, const BatchTable& table) {
  const std::filesystem::path temporary = file.string() + ".new";
  std::error_code error;
  for (const char* suffix : {"", "-journal", "-wal"})
    std::filesystem::remove(temporary.string() + suffix, error);
  if (Status status = WriteTables(temporary, table); !status.ok()) return status;
  std::filesystem::rename(temporary, file, error);
  if (error)
    return Error{ErrorCode::kIo, "cannot write '" + file.string() + "': " + error.message()};
  SyncFolderOf(file);
  return {};
}

Result<BatchTable> ReadBatchResults(const std::filesystem::path& file_or_folder) {
  std::error_code error;
  const bool folder = std::filesystem::is_directory(file_or_folder, error);
  const std::filesystem::path file = folder ? file_or_folder / kBatchResults : file_or_folder;
  if (!std::filesystem::exists(file, error)) {
    return Error{ErrorCode::kNotFound, "there is no '" + file.string() +
                                           "'; name the folder of a batch or its results.sqlite"};
  }
  if (!std::filesystem::is_regular_file(file, error))
    return InvalidInput("'" + file.string() + "' is no file that can be read");
  auto database = sqlite::Database::OpenToRead(file);
  if (!database.ok()) return OfResults(file, database.error());
  const auto id = (*database)->QueryInteger("PRAGMA application_id");
  if (!id.ok()) return OfResults(file, id.error());
  if (*id != kBatchApplicationId) return OfResults(file, InvalidInput(""));
  const auto version = (*database)->QueryInteger("PRAGMA user_version");
  if (!version.ok()) return version.error();
  if (*version > kBatchFormatVersion)
    return InvalidInput("'" + file.string() + "' is of a newer version of Plumbline");
  return ResultsReader(**database).Read();
}

}  // namespace plumbline
