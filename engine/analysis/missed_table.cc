// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/missed_table.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "engine/analysis/missed_truths.h"

namespace plumbline {
namespace {

/// Fills in what one run, the newest of the table, says.
void AddRun(const JudgedRun& run, MissedTable& table) {
  table.runs.push_back(&run);
  for (const TruthView& truth : run.truths.truths) {
    auto row = std::find_if(table.rows.begin(), table.rows.end(),
                            [&](const MissedTable::Row& r) { return r.truth == truth.id; });
    if (row == table.rows.end()) {
      table.rows.push_back({truth.id, truth.model, {}, 0});
      row = std::prev(table.rows.end());
    }
    row->by_run.resize(table.runs.size() - 1);
    row->by_run.push_back(&truth);
    row->found += truth.found;
  }
  for (MissedTable::Row& row : table.rows) row.by_run.resize(table.runs.size());
}

nlohmann::json CountsToJson(const std::map<MissedCause, int>& causes) {
  nlohmann::json json = nlohmann::json::object();
  for (const auto& [cause, count] : causes) json[NameOf(cause)] = count;
  return json;
}

nlohmann::json RowToJson(const MissedTable& table, const MissedTable::Row& row) {
  nlohmann::json by_run = nlohmann::json::object();
  for (std::size_t i = 0; i < row.by_run.size(); ++i) {
    const TruthView* truth = row.by_run[i];
    if (truth == nullptr) continue;
    nlohmann::json told = {{"found", truth->found}};
    if (!truth->found) told["why"] = WhyMissedToJson(*truth);
    by_run[table.runs[i]->name] = std::move(told);
  }
  return {{"id", row.truth},
          {"model", row.model},
          {"found_in", row.found},
          {"runs", std::move(by_run)}};
}

}  // namespace

std::vector<MissedTable> MissedTables(std::span<const JudgedRun> runs) {
  std::vector<MissedTable> tables;
  for (const JudgedRun& run : runs) {
    auto table = std::find_if(tables.begin(), tables.end(),
                              [&](const MissedTable& t) { return t.scene == run.scene; });
    if (table == tables.end()) {
      tables.push_back({run.scene, {}, {}});
      table = std::prev(tables.end());
    }
    AddRun(run, *table);
  }
  return tables;
}

std::map<MissedCause, int> CausesOf(std::span<const JudgedRun> runs) {
  std::map<MissedCause, int> causes;
  for (const JudgedRun& run : runs) {
    for (const TruthView& truth : run.truths.truths) {
      if (!truth.found) ++causes[truth.cause];
    }
  }
  return causes;
}

nlohmann::json MissedTablesToJson(std::span<const JudgedRun> runs) {
  nlohmann::json scenes = nlohmann::json::array();
  for (const MissedTable& table : MissedTables(runs)) {
    nlohmann::json of_runs = nlohmann::json::array(), truths = nlohmann::json::array();
    for (const JudgedRun* run : table.runs) {
      of_runs.push_back({{"run", run->name},
                         {"found", run->truths.found},
                         {"missed", run->truths.missed},
                         {"causes", CountsToJson(CausesOf({run, 1}))}});
    }
    for (const MissedTable::Row& row : table.rows) truths.push_back(RowToJson(table, row));
    scenes.push_back(
        {{"scene", table.scene}, {"runs", std::move(of_runs)}, {"truths", std::move(truths)}});
  }
  return {{"scenes", std::move(scenes)}, {"causes", CountsToJson(CausesOf(runs))}};
}

}  // namespace plumbline
