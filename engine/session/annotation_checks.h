// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/annotation/annotation_images.h"
#include "engine/annotation/image_refinement.h"
#include "engine/annotation/outline_scene.h"
#include "engine/base/progress.h"
#include "engine/snapshot/annotation_snapshot.h"

namespace plumbline {

/// Key frames that show one instance.
struct InstanceImages {
  std::string instance, model_name;
  Eigen::Isometry3d chosen_for = Eigen::Isometry3d::Identity();  ///< Pose they were chosen for.
  std::optional<Eigen::Isometry3d> scan_from_world;  ///< By which the cameras were placed.
  std::shared_ptr<const OutlineModel> model;
  std::shared_ptr<const AnnotationImages> images;  ///< Null: no frame shows it.

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

/// The outline of a pose in all of them; some tens of milliseconds.
ImageChecksView CheckPose(const InstanceImages& images, const Eigen::Isometry3d& scan_from_object,
                          const Occluders& occluders);

/// Aligns the outline with the edges of all images. What went wrong is in `problem`.
void RefineInImages(const InstanceImages& images, const Occluders& occluders,
                    const Eigen::Vector3d& up_in_scan, FreeMotion motion, const WorkContext& work,
                    RefinementView& refinement);

}  // namespace plumbline
