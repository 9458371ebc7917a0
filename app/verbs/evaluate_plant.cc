// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/evaluate_plant.h"

#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "app/verbs/console_work.h"
#include "engine/analysis/missed_truths.h"
#include "engine/analysis/true_instances.h"
#include "engine/base/check.h"
#include "engine/mapping/map_report.h"
#include "engine/recording/run_fork.h"

namespace plumbline {
namespace {

Result<PlantedTruth> PlantOne(const ForkChoice& fork, const std::filesystem::path& ground_truth,
                              const std::string& id, const WorkContext& work) {
  if (Status status = ForkRun(fork, work); !status.ok()) return status.error();
  const Result<RunReview> review =
      ReviewRun({fork.out, fork.run.sequence, fork.run.models}, ground_truth, work);
  if (!review) return review.error();
  const TruthsView truths = TruthsOf(*review);
  const TruthView* truth = FindTruth(truths, id);
  PLB_CHECK(truth != nullptr);
  return JudgePlanted(*truth, ObjectPlanted(review->events, fork.plant->why), fork.at,
                      fork.options.confirm_evidence);
}

}  // namespace

Result<std::map<std::string, PlantedTruth>> PlantMissed(const RunChoice& run,
                                                        const std::filesystem::path& ground_truth,
                                                        const RunReview& review,
                                                        const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + folder.string() + "': " + error.message()};
  }
  std::map<std::string, PlantedTruth> planted;
  const TruthsView truths = TruthsOf(review);
  ConsoleWork console;
  for (std::size_t i = 0; i < truths.truths.size(); ++i) {
    const TruthView& truth = truths.truths[i];
    const std::optional<int> after = FrameToPlantAfter(review.history, i);
    if (truth.found || truth.cause == MissedCause::kNotSeen || !after) continue;
    ForkChoice fork;
    fork.run = run;
    fork.at = *after;
    fork.options = review.header.recipe.options;
    fork.seed = review.header.recipe.seed;
    fork.out = folder / (run.run.stem().string() + "." + truth.id + ".plb");
    fork.program_version = review.header.program_version;
    fork.plant = PlantTruth(review.view, truth.id);
    WorkContext work = console.context();
    const std::string stage = "Mapping with " + truth.id + " planted";
    work.report = [report = work.report, &stage](Progress progress) {
      progress.stage = stage;
      report(progress);
    };
    Result<PlantedTruth> one = PlantOne(fork, ground_truth, truth.id, work);
    if (!one) return one.error();
    planted.emplace(truth.id, std::move(*one));
  }
  return planted;
}

}  // namespace plumbline
