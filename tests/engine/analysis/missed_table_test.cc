// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/missed_table.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace plumbline {
namespace {

TruthView FoundTruth(const std::string& id) {
  TruthView truth;
  truth.id = id;
  truth.model = "stool";
  truth.found = true;
  return truth;
}

TruthView MissedTruth(const std::string& id, MissedCause cause) {
  TruthView truth = FoundTruth(id);
  truth.found = false;
  truth.cause = cause;
  truth.text = "because";
  return truth;
}

JudgedRun RunOf(const std::string& name, const std::string& scene, std::vector<TruthView> truths) {
  JudgedRun run{name, scene, {}};
  for (const TruthView& truth : truths) ++(truth.found ? run.truths.found : run.truths.missed);
  run.truths.truths = std::move(truths);
  return run;
}

std::vector<JudgedRun> ThreeRuns() {
  return {
      RunOf("a", "kitchen", {FoundTruth("table"), MissedTruth("chair", MissedCause::kNeverBoxed)}),
      RunOf("o", "office", {MissedTruth("chair", MissedCause::kWithdrawn)}),
      RunOf("b", "kitchen", {FoundTruth("chair"), MissedTruth("lamp", MissedCause::kNeverBoxed)})};
}

TEST(MissedTables, HaveARowForEachInstanceOfAScene) {
  const std::vector<JudgedRun> runs = ThreeRuns();
  const std::vector<MissedTable> tables = MissedTables(runs);
  ASSERT_EQ(tables.size(), 2u);
  const MissedTable& kitchen = tables[0];
  EXPECT_EQ(kitchen.scene, "kitchen");
  ASSERT_EQ(kitchen.runs.size(), 2u);
  EXPECT_EQ(kitchen.runs[1]->name, "b");
  ASSERT_EQ(kitchen.rows.size(), 3u);
  for (const MissedTable::Row& row : kitchen.rows) ASSERT_EQ(row.by_run.size(), 2u) << row.truth;
  EXPECT_EQ(kitchen.rows[0].truth, "table");
  EXPECT_EQ(kitchen.rows[0].by_run[1], nullptr) << "run b does not know it";
  EXPECT_EQ(kitchen.rows[1].truth, "chair");
  EXPECT_EQ(kitchen.rows[1].found, 1);
  EXPECT_EQ(kitchen.rows[1].by_run[0]->cause, MissedCause::kNeverBoxed);
  EXPECT_EQ(kitchen.rows[2].by_run[0], nullptr);
  EXPECT_EQ(tables[1].rows.size(), 1u) << "a chair of the office is another one";
}

TEST(MissedTables, CountCauses) {
  const std::vector<JudgedRun> runs = ThreeRuns();
  const auto causes = CausesOf(runs);
  EXPECT_EQ(causes.size(), 2u);
  EXPECT_EQ(causes.at(MissedCause::kNeverBoxed), 2);
  EXPECT_EQ(causes.at(MissedCause::kWithdrawn), 1);
}

TEST(MissedTables, WriteAllOfItAsJson) {
  const nlohmann::json json = MissedTablesToJson(ThreeRuns());
  EXPECT_EQ(json["causes"], (nlohmann::json{{"never_boxed", 2}, {"withdrawn", 1}}));
  const nlohmann::json& kitchen = json["scenes"][0];
  EXPECT_EQ(kitchen["runs"][1]["causes"], (nlohmann::json{{"never_boxed", 1}}));
  EXPECT_EQ(kitchen["runs"][0]["found"], 1);
  const nlohmann::json& chair = kitchen["truths"][1];
  EXPECT_EQ(chair["id"], "chair");
  EXPECT_EQ(chair["found_in"], 1);
  EXPECT_EQ(chair["runs"]["a"]["why"]["cause"], "never_boxed");
  EXPECT_EQ(chair["runs"]["b"]["found"], true);
  EXPECT_FALSE(chair["runs"]["b"].contains("why"));
}

}  // namespace
}  // namespace plumbline
