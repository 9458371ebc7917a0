// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/annotation/annotation_images.h"
#include "engine/annotation/outline_scene.h"
#include "engine/base/progress.h"
#include "engine/session/annotation_jobs.h"
#include "engine/snapshot/annotation_snapshot.h"

namespace plumbline {

/// Key frames that show one instance.
struct InstanceImages {
  std::string instance, model_name;
  double scale = 1;             ///< Of `model`.
  std::uint64_t placement = 0;  ///< PlacementView::asked_by, if they are for its candidates.
  Eigen::Isometry3d chosen_for = Eigen::Isometry3d::Identity();  ///< Pose they were chosen for.
  std::optional<Eigen::Isometry3d> scan_from_world;  ///< By which the cameras were placed.
  std::shared_ptr<const OutlineModel> model;
  /// All, those that are refined on first, then those held out; null: no frame shows it.
  std::shared_ptr<const AnnotationImages> images;
  HeldOutImages apart;

  /// Whether they still suit the instance: it has neither gone far from where it was when they were
  /// chosen nor become another model, and the cameras are where they were.
  bool Suit(const AnnotationDocument& document, const AnnotatedInstance& instance) const;
  /// For an instance that no image can be had of.
  static InstanceImages None(const AnnotationDocument& document, const std::string& instance);
};

/// Chooses the frames and finds their edges; seconds. Errors: kNotFound (model), kCancelled and
/// what goes wrong with the images.
Result<InstanceImages> ReadInstanceImages(const std::shared_ptr<const Sequence>& sequence,
                                          const AnnotationDocument& document,
                                          const std::string& instance, OutlineScene& scene,
                                          const WorkContext& work);

/// The outline of a pose in all of them; some tens of milliseconds. `others` are drawn beside it.
struct ComparedPose {
  std::optional<RefineBy> by;  ///< Nothing: where it is placed.
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
};
ImageChecksView CheckPose(const InstanceImages& images, const Eigen::Isometry3d& scan_from_object,
                          const std::vector<ComparedPose>& others, const Occluders& occluders);

/// What an instance is refined by.
struct RefinementTask {
  RefineBy by = RefineBy::kBoth;
  std::optional<PlacementTask> scan;             ///< Nothing: there is none.
  std::shared_ptr<const InstanceImages> images;  ///< Null: there are none.
  Occluders occluders;
  Eigen::Vector3d up_in_scan{0, 0, 1};
  FreeMotion motion = FreeMotion::kAzimuthAndTranslation;
  bool free_scale = false;  ///< Only the scan tells it.
};

/// Finds the scale of what is refined and makes shapes of that size for the rest of the refinement;
/// how large it is goes into `refinement`. Without a scan, or where that does not show it, the
/// scale stays as it is.
void SolveScale(OutlineScene* outlines, const WorkContext& work, RefinementTask& task,
                RefinementView& refinement);

/// Refines from where `refinement` is, a step on the scan at a time, each told to `step`; at most a
/// step in `pace_ms`, so that people can follow. What went wrong is in `problem`.
void RefineInstance(const RefinementTask& task, const WorkContext& work, int pace_ms,
                    const std::function<void(const RefinementView&)>& step,
                    RefinementView& refinement);
/// Proposes one of the poses that were found.
void ProposePose(const RefinedPose& pose, const PlacementTask* scan, RefinementView& refinement);

}  // namespace plumbline
