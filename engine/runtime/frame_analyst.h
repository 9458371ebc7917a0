// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "engine/analysis/relations.h"
#include "engine/runtime/network_analyst.h"
#include "engine/snapshot/commands.h"
#include "engine/snapshot/frame_analysis.h"
#include "engine/snapshot/object_history.h"
#include "engine/snapshot/playback_view.h"
#include "engine/snapshot/run_history.h"
#include "engine/snapshot/timing_statistics.h"
#include "engine/snapshot/truths_view.h"

namespace plumbline {

struct MapSnapshot;

/// Works out what is watched of a run, so that the window does not have to. Use it in one thread.
class FrameAnalyst {
 public:
  void Watch(const WatchCommand& what) { watched_ = what; }
  /// @param options  That the frame was mapped with.
  /// @param recipe  Of the run; null: unknown.
  std::shared_ptr<const FrameAnalysis> OfFrame(std::shared_ptr<const MapSnapshot> frame,
                                               const SequenceView& sequence,
                                               const MapperOptions& options,
                                               const RunRecipe* recipe = nullptr);
  /// Null unless the history of an object is watched. A few milliseconds for 10 000 frames.
  std::shared_ptr<const ObjectHistory> OfHistory(const RunHistory& history,
                                                 const SequenceView& sequence) const;
  /// Null without ground truth. A few milliseconds for 10 000 frames.
  static std::shared_ptr<const TruthsView> OfTruths(const RunHistory& history,
                                                    std::span<const FrameEvent> events,
                                                    const SequenceView& sequence,
                                                    const MapperOptions& options);
  /// Null unless they are watched.
  std::shared_ptr<const TimingStatistics> OfTimings(const RunHistory& history) const;

 private:
  WatchCommand watched_;
  RelationFinder relations_;
  NetworkAnalyst networks_;
};

}  // namespace plumbline
