// SPDX-License-Identifier: Apache-2.0
// Many runs: plans, what describes a batch system, results of a run and of a batch.
#include <array>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/batch/batch_engines.h"
#include "engine/batch/batch_jobs.h"
#include "engine/batch/batch_results.h"
#include "engine/batch/batch_review.h"
#include "tests/fuzz/fuzz_targets.h"

namespace plumbline::fuzz {
namespace {

Status Plan(std::string_view input) {
  const auto plan = ReadBatchPlan(FileOf("plan.json", input));
  if (!plan.ok()) return plan.error();
  (void)PointsOf(*plan);
  return StatusOf(BatchPlanFromJson(BatchPlanToJson(*plan), "/"));  // what is written is read again
}

Status System(std::string_view input) {
  return StatusOf(ReadClusterCommands(FileOf("system.json", input)));
}

Status Results(std::string_view input) {
  auto table = ReadBatchResults(FileOf("results.sqlite", input));
  if (!table.ok()) return table.error();
  if (const auto gate = GateBatch(*table, *table, {}); !gate.ok()) return gate.error();
  (void)CausesByRecipe(*table);
  (void)ReviewBatch(std::move(*table));
  return {};
}

/// result.json of one run, as it is collected: damage makes the run "lost" or "failed".
Status JobResult(std::string_view input) {
  const std::filesystem::path file = FileOf("result.json", input);
  PlannedSequence sequence;
  sequence.name = "a";
  BatchPlan plan;
  plan.sequences.push_back(sequence);
  plan.recipes.push_back({"x", {}, {}});
  plan.seeds = {0};
  Batch batch = MakeBatch(file.parent_path(), "program", plan, {});
  batch.jobs.front().folder = ".";
  const BatchTable table = CollectTable(batch);
  if (table.runs.front().status == "ok") return {};
  return InvalidInput("the run is " + table.runs.front().status);
}

constexpr std::array kBatchTargets = {Target{"batch_plan", Plan}, Target{"batch_system", System},
                                      Target{"batch_results", Results},
                                      Target{"batch_run_result", JobResult}};

}  // namespace

std::span<const Target> BatchTargets() { return kBatchTargets; }

}  // namespace plumbline::fuzz
