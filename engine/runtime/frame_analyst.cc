// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/frame_analyst.h"

#include <utility>

#include "engine/analysis/label_history.h"
#include "engine/analysis/missed_truths.h"
#include "engine/analysis/object_spread.h"
#include "engine/analysis/reliability.h"
#include "engine/analysis/timing_statistics.h"
#include "engine/mapping/likelihood.h"
#include "engine/mapping/particle_rank.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

std::shared_ptr<const FrameAnalysis> FrameAnalyst::OfFrame(std::shared_ptr<const MapSnapshot> frame,
                                                           const SequenceView& sequence,
                                                           const MapperOptions& options,
                                                           const RunRecipe* recipe) {
  auto analysis = std::make_shared<FrameAnalysis>();
  const MapSnapshot& snapshot = *frame;
  analysis->object = watched_.object;
  for (const ObjectReport& object : snapshot.report.objects) {
    const ModelView& model = sequence.models[static_cast<std::size_t>(object.label.value)];
    analysis->spreads.push_back(SpreadOf(object, sequence));
    if (object.id == watched_.object && object.particles != nullptr)
      analysis->by_rank = ByRank(*object.particles,
                                 object.state == ObjectState::kConfirmed
                                     ? options.alpha
                                     : DetectorWeight(model.category, model.bounds, options),
                                 options.beta);
  }
  if (watched_.relations)
    analysis->relations = relations_.Find(snapshot.report, sequence, snapshot.depth, snapshot.id);
  if (!watched_.edges.empty())
    analysis->other_edges = networks_.EdgesOf(snapshot.image, watched_.edges);
  if (watched_.score_map)
    analysis->score_map = networks_.ScoresOf(snapshot, watched_.object, recipe);
  analysis->frame = std::move(frame);
  return analysis;
}

std::shared_ptr<const ObjectHistory> FrameAnalyst::OfHistory(const RunHistory& history,
                                                             const SequenceView& sequence) const {
  if (!watched_.history || watched_.object.value <= 0) return nullptr;
  return std::make_shared<const ObjectHistory>(
      ObjectHistory{watched_.object, LabelsOf(history, watched_.object), ReliabilityOf(history),
                    ConfirmationOf(history, static_cast<int>(sequence.truth.size()))});
}

std::shared_ptr<const TruthsView> FrameAnalyst::OfTruths(const RunHistory& history,
                                                         std::span<const FrameEvent> events,
                                                         const SequenceView& sequence,
                                                         const MapperOptions& options) {
  if (sequence.truth.empty()) return nullptr;
  return std::make_shared<const TruthsView>(
      TruthsOf(history, events, sequence, options.confirm_evidence));
}

std::shared_ptr<const TimingStatistics> FrameAnalyst::OfTimings(const RunHistory& history) const {
  if (!watched_.timings) return nullptr;
  return std::make_shared<const TimingStatistics>(StatisticsOf(history));
}

}  // namespace plumbline
