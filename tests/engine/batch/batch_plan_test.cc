// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_plan.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/batch/batch_jobs.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

const json kWhole = json::parse(R"({
  "name": "all of it",
  "sequences": ["rooms/a", {"path": "b/", "name": "bee", "ground_truth": "truth.json"},
                {"name": "drawn", "synth": {"scene": "room", "frames": 30, "imu": true},
                 "seeds": "101:103"}],
  "recipes": [{"name": "default"},
              {"name": "blunt", "set": {"beta": 0.5}, "edges": "gradient", "frames": "0:20"},
              {"name": "old", "program": "old/plumbline", "set": {"of_another_time": 1}}],
  "seeds": [3, 1],
  "sweep": {"alpha": {"from": 1, "to": 2, "steps": 3}, "particles": [50, 100]},
  "evaluate": {"samples": 5000, "ignore_categories": ["lamp"]},
  "timeout_s": 60, "gate": ["found"], "slurm": ["--mem=2G"]})");

std::string WhatIsWrong(const std::function<void(json&)>& change) {
  json plan = {{"sequences", {"a"}}};
  change(plan);
  const auto read = BatchPlanFromJson(plan, "/plans");
  return read.ok() ? "" : read.error().message;
}

TEST(BatchPlan, ReadsEverything) {
  const BatchPlan plan = BatchPlanFromJson(kWhole, "/plans").value();
  ASSERT_EQ(plan.sequences.size(), 4U);
  EXPECT_EQ(plan.sequences[0].name, "a");
  EXPECT_EQ(plan.sequences[0].path, "/plans/rooms/a");
  EXPECT_EQ(plan.sequences[1].name, "bee");
  EXPECT_EQ(plan.sequences[1].path, "/plans/b");
  EXPECT_EQ(plan.sequences[1].ground_truth, "/plans/truth.json");
  EXPECT_EQ(plan.sequences[3].name, "drawn-102");
  EXPECT_THAT(plan.sequences[3].synth,
              ElementsAre("--frames", "30", "--imu", "--scene", "room", "--seed", "102"));
  ASSERT_EQ(plan.recipes.size(), 3U);
  EXPECT_THAT(plan.recipes[1].words,
              ElementsAre("--frames", "0:20", "--edges", "gradient", "--set", "beta=0.5"));
  EXPECT_EQ(plan.recipes[2].program, "/plans/old/plumbline");
  EXPECT_THAT(plan.seeds, ElementsAre(3U, 1U));
  EXPECT_THAT(PointsOf(plan),
              ElementsAre(ElementsAre(1, 50), ElementsAre(1, 100), ElementsAre(1.5, 50),
                          ElementsAre(1.5, 100), ElementsAre(2, 50), ElementsAre(2, 100)));
  EXPECT_EQ(plan.evaluation.samples, 5000);
  EXPECT_EQ(plan.timeout_s, 60);
}

TEST(BatchPlan, WhatIsWrittenIsReadAgain) {
  const json written = BatchPlanToJson(BatchPlanFromJson(kWhole, "/plans").value());
  EXPECT_EQ(BatchPlanToJson(BatchPlanFromJson(written, "/elsewhere").value()), written);
}

TEST(BatchPlan, RoundsRangesOfWholeOptions) {
  const auto plan = BatchPlanFromJson(
      {{"sequences", {"a"}},
       {"sweep", {{"particles", {{"from", 50}, {"to", 500}, {"steps", 4}, {"log", true}}}}}},
      "/plans");
  EXPECT_THAT(plan.value().sweep[0].values, ElementsAre(50, 108, 232, 500));
}

TEST(BatchPlan, RefusesWhatMakesNoSense) {
  EXPECT_EQ(WhatIsWrong([](json&) {}), "");
  EXPECT_THAT(WhatIsWrong([](json& p) { p["seqences"] = 1; }), HasSubstr("'sequences'?"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p.erase("sequences"); }), HasSubstr("needs 'sequences'"));
  EXPECT_THAT(WhatIsWrong([](json& p) {
                p["sequences"] = {"a", "b/a"};
              }),
              HasSubstr("two sequences are named 'a'"));
  EXPECT_THAT(WhatIsWrong([](json& p) {
                p["sequences"][0] = {{"name", "x"}};
              }),
              HasSubstr("neither 'path' nor 'synth'"));
  EXPECT_THAT(WhatIsWrong([](json& p) {
                p["recipes"] = {{{"name", "x"}, {"set", {{"bta", 1}}}}};
              }),
              HasSubstr("did you mean 'beta'"));
  EXPECT_THAT(WhatIsWrong([](json& p) {
                p["recipes"] = {{{"name", "x"}, {"arguments", {"--out", "y"}}}};
              }),
              HasSubstr("--out"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["recipes"] = {{{"name", "a/b"}}}; }), HasSubstr("slash"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["seeds"] = {1, 1}; }), HasSubstr("twice"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["seeds"] = {-1}; }), HasSubstr("whole number"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["seeds"] = "5:3"; }), HasSubstr("no range"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["seeds"] = "0:99999999999"; }), HasSubstr("no range"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["sweep"] = {{"beta", {1}}}; }), HasSubstr("two values"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["sweep"] = {{"bta", {1, 2}}}; }), HasSubstr("'beta'"));
  EXPECT_THAT(WhatIsWrong([](json& p) {
                p["sweep"] = {{"beta", {1, -7}}};
              }),
              HasSubstr("'beta' of 'sweep'"));
  EXPECT_THAT(WhatIsWrong([](json& p) {
                p["recipes"] = {{{"name", "x"}, {"set", {{"beta", 1}}}}};
                p["sweep"] = {{"beta", {1, 2}}};
              }),
              HasSubstr("also set by the recipe 'x'"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["gate"] = {"fond"}; }), HasSubstr("'found'"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["gate"] = {"in_95"}; }), HasSubstr("better or worse"));
  EXPECT_THAT(WhatIsWrong([](json& p) { p["timeout_s"] = 0; }), HasSubstr("above 0"));
  EXPECT_THAT(WhatIsWrong([](json& p) {
                p["seeds"] = "0:900000";
                p["sequences"] = {"a", "b"};
              }),
              HasSubstr("1800000 runs"));
}

/// A batch whose program is any file.
Batch BatchOf(const TemporaryFolder& folder, const json& plan, const std::string& program) {
  const std::filesystem::path file = folder.path() / "program";
  EXPECT_TRUE(WriteFileAtomically(file, program).ok());
  const BatchPlan read = BatchPlanFromJson(plan, "/plans").value();
  return MakeBatch(folder.path(), file, read, HashPrograms(read, file).value());
}

TEST(BatchJobs, AreOrderedBySeedFirstAndHaveFoldersOfTheirOwn) {
  const TemporaryFolder folder;
  const Batch batch = BatchOf(
      folder, {{"sequences", {"a", "b"}}, {"seeds", {0, 7}}, {"sweep", {{"beta", {0.5, 1}}}}}, "x");
  ASSERT_EQ(batch.jobs.size(), 8U);
  std::set<std::string> folders;
  for (const BatchJob& job : batch.jobs) folders.insert(job.folder);
  EXPECT_EQ(folders.size(), 8U);
  EXPECT_THAT(batch.jobs[0].folder, testing::StartsWith("jobs/a.default.beta=0.5.seed0-"));
  EXPECT_THAT(batch.jobs[1].folder, testing::StartsWith("jobs/b.default.beta=0.5.seed0-"));
  EXPECT_THAT(batch.jobs[7].folder, testing::StartsWith("jobs/b.default.beta=1.seed7-"));
}

TEST(BatchJobs, ResultsOfAnotherProgramOrSettingAreNotTakenForTheirs) {
  const TemporaryFolder folder;
  const json plan = {{"sequences", {"a"}}, {"recipes", {{{"name", "x"}}}}};
  json other = plan;
  other["recipes"][0]["set"] = {{"beta", 0.5}};
  const std::string name = BatchOf(folder, plan, "one build").jobs[0].folder;
  EXPECT_EQ(BatchOf(folder, plan, "one build").jobs[0].folder, name);
  EXPECT_NE(BatchOf(folder, plan, "another build").jobs[0].folder, name);
  EXPECT_NE(BatchOf(folder, other, "one build").jobs[0].folder, name);
}

}  // namespace
}  // namespace plumbline
