// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "engine/base/progress.h"
#include "engine/mapping/likelihood.h"
#include "engine/mapping/occlusion.h"
#include "engine/mapping/rendered_scorer.h"
#include "engine/mapping/viewpoint_scorer.h"
#include "engine/snapshot/commands.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/snapshot/probe_view.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

/// What hypotheses are compared with.
struct ProbedTruth {
  std::optional<int> index = {};  ///< Into SequenceView::truth; nothing: there is none.
  ObjectId explained_by = {};     ///< Another object than the one asked about is paired with it.
};

/// Scores again what a frame's particles were scored by, and what they were not: the truth, places
/// around the mean. Edges come from the snapshot; the detector's scores from the proposals that the
/// frame reports, which is exact for `--detector dataset` and close for networks. What hides the
/// object is taken from the means after the frame instead of before it. Use it in one thread.
class HypothesisProbe {
 public:
  /// The models' contours are read from the cache or built (seconds). Errors: kCancelled.
  static Result<std::unique_ptr<HypothesisProbe>> Create(
      const PinholeCamera& camera, std::shared_ptr<const ModelDatabase> database,
      std::optional<Eigen::Vector4d> floor_in_world, const WorkContext& work);

  /// A request that cannot be answered gives a view with a message. Where `request` names a true
  /// instance, that comes first among the hypotheses, and those of `request.object`, the candidate
  /// for it, follow if there is one.
  /// @param options  Those that the frame was mapped with.
  ProbeView Probe(const MapSnapshot& snapshot, const SequenceView& sequence,
                  const MapperOptions& options, const ProbeCommand& request,
                  const ProbedTruth& truth);

 private:
  struct Frame;
  HypothesisProbe() = default;
  std::vector<Likelihood> Score(const Frame& frame, const HypothesisScorer& scorer,
                                std::span<const PoseHypothesis> hypotheses) const;
  void AddHypotheses(const Frame& frame, const ProbeCommand& request, ProbeView& view) const;
  void AddParticles(const Frame& frame, const ProbeCommand& request, ProbeView& view) const;
  void ScoreHypotheses(const Frame& frame, const HypothesisScorer* reference, const EdgeMap& edges,
                       ProbeView& view) const;
  void AddOutlines(const Frame& frame, int hovered, ProbeView& view);
  struct Axis;
  static std::vector<Axis> Axes(const Frame& frame, const ProbeView& view);
  void AddSlices(const Frame& frame, const HypothesisScorer* reference, ProbeView& view) const;
  void AddMap(const Frame& frame, const Axis& x, const Axis& y, ProbeView& view) const;
  std::vector<ContourSample> Samples(const Frame& frame, const PoseHypothesis& hypothesis,
                                     const EdgeMap& edges) const;

  PinholeCamera camera_;
  std::shared_ptr<const ModelDatabase> database_;
  MapperOptions options_;  ///< Of the last request.
  std::optional<Eigen::Vector4d> floor_in_world_;
  std::unique_ptr<ViewpointScorer> scorer_;
  std::unique_ptr<OcclusionRenderer> renderer_;
  std::unique_ptr<RenderedScorer> reference_;  ///< Made when first asked for.
  bool reference_failed_ = false;
  int table_frame_ = -1;
  bool table_is_narrow_ = false;
  std::shared_ptr<const OrientedTable> table_;
};

/// A probe that is made when it is first asked.
class LazyProbe {
 public:
  LazyProbe(const PinholeCamera& camera, std::shared_ptr<const ModelDatabase> database,
            std::optional<Eigen::Vector4d> floor_in_world)
      : camera_(camera), database_(std::move(database)), floor_in_world_(floor_in_world) {}
  ProbeView Probe(const MapSnapshot& snapshot, const SequenceView& sequence,
                  const MapperOptions& options, const ProbeCommand& request,
                  const ProbedTruth& truth);

 private:
  PinholeCamera camera_;
  std::shared_ptr<const ModelDatabase> database_;
  std::optional<Eigen::Vector4d> floor_in_world_;
  std::unique_ptr<HypothesisProbe> probe_;
};

}  // namespace plumbline
