// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/probe_answer.h"

#include "engine/analysis/true_instances.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr double kFarthestCompared_m = 1.5;

}  // namespace

ProbeView AnswerProbe(LazyProbe& probe, const MapSnapshot& snapshot, const SequenceView& view,
                      const MapperOptions& options, const ProbeCommand& request) {
  const FrameReport& report = snapshot.report;
  if (request.truth.empty()) {
    const auto compared = TruthToCompare(report, view, request.object, kFarthestCompared_m);
    return probe.Probe(
        snapshot, view, options, request,
        compared ? ProbedTruth{compared->truth, compared->explained_by} : ProbedTruth());
  }
  ProbeCommand of_truth = request;
  ProbedTruth truth;
  for (std::size_t i = 0; i < view.truth.size(); ++i) {
    if (view.truth[i].id == request.truth) truth.index = static_cast<int>(i);
  }
  if (truth.index) {
    const ObjectReport* candidate = CandidateFor(report, view, *truth.index);
    of_truth.object = candidate != nullptr ? candidate->id : ObjectId();
  }
  return probe.Probe(snapshot, view, options, of_truth, truth);
}

}  // namespace plumbline
