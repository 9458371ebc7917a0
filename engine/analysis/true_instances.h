// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "engine/base/ids.h"
#include "engine/geometry/box.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/snapshot/run_history.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

struct FrameReport;
struct ObjectReport;

/// Objects further than this from every true instance are compared with none.
inline constexpr double kFarthestTruth_m = 1.0;

/// Null for a name that the sequence has no model for.
const ModelView* ModelByName(const SequenceView& view, const std::string& name);

/// The true instance of each object of the frame, one to one, as an index into `view.truth`.
/// Confirmed objects come first, by the rule of `plumbline evaluate`; then tentative ones, within
/// the same reach; then what is left, within kFarthestTruth_m. Retired objects have none.
std::vector<std::optional<int>> TruthsOfObjects(const FrameReport& report,
                                                const SequenceView& view);

/// What an object of the frame is compared with: its instance or, without one, the nearest of its
/// category within `reach_m`, and the other object that has it.
struct ComparedTruth {
  int truth = -1;  ///< Index into `view.truth`.
  ObjectId explained_by;
};
std::optional<ComparedTruth> TruthToCompare(const FrameReport& report, const SequenceView& view,
                                            ObjectId object, double reach_m);

/// The object that is paired with an instance or could become it: then the nearest of its category
/// within kFarthestTruth_m that is paired with none. Null without one.
const ObjectReport* CandidateFor(const FrameReport& report, const SequenceView& view, int truth);

/// A true instance as a candidate for the mapper; nothing for an id that there is none of.
std::optional<PlantedObject> PlantTruth(const SequenceView& view, const std::string& instance);

/// How much of each true instance shows in an image. The true models hide one another; what is not
/// annotated (walls, clutter) hides nothing. Use it in one thread.
class TruthVisibility {
 public:
  explicit TruthVisibility(const SequenceView& view);
  ~TruthVisibility();
  TruthVisibility(TruthVisibility&&) noexcept;
  TruthVisibility& operator=(TruthVisibility&&) noexcept;

  struct Shown {
    float pixels = 0;
    Box2 box;
  };
  /// By rays, one for every few pixels: a millisecond or two. As in `view.truth`.
  std::vector<Shown> From(const Eigen::Isometry3d& world_from_cam) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

/// Every true instance in one frame.
/// @param pairs  As from TruthsOfObjects.
std::vector<TruthSample> TruthSamplesOf(const FrameReport& report, const SequenceView& view,
                                        const std::vector<std::optional<int>>& pairs,
                                        const TruthVisibility& visibility);

}  // namespace plumbline
