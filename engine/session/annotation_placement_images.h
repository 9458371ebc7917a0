// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "engine/annotation/outline_scene.h"
#include "engine/base/progress.h"
#include "engine/dataset/sequence.h"
#include "engine/registration/constrained_fit.h"
#include "engine/snapshot/annotation_snapshot.h"

namespace plumbline {

/// What images can say about where a model goes.
struct PlacementImages {
  std::shared_ptr<const Sequence> sequence;
  std::shared_ptr<OutlineScene> outlines;
  AnnotationDocument document;
  std::string model;
  Eigen::Vector3d up_in_scan{0, 0, 1};
  FreeMotion motion = FreeMotion::kAzimuthAndTranslation;
};

/// Gives each candidate its agreement with the same few key frames. Where none agrees, the scan
/// does not show the object, or shows too little of it: then all azimuths around `start` are tried
/// in the images alone, and what agrees is added. Where the images clearly prefer a candidate to
/// the first, it becomes the first. `changed` is called when there is something new to see. Without
/// a frame that shows the place nothing changes.
void ComparePlacements(const PlacementImages& task, const Eigen::Isometry3d& start,
                       const WorkContext& work,
                       const std::function<void(const PlacementView&)>& changed,
                       PlacementView& placement);

}  // namespace plumbline
