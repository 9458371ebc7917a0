// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "engine/dataset/sequence.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/vio/own_pose_report.h"
#include "engine/vio/own_poses.h"
#include "engine/vision/detector.h"
#include "engine/vision/edge_detector.h"

namespace plumbline {

/// Parts of a mapping pipeline that its caller has already, in other processes perhaps. What is
/// null is made from the recipe.
struct PipelineParts {
  std::shared_ptr<const Sequence> sequence;    ///< With poses, unless poses = vio ...
  std::shared_ptr<const OwnPoses> own_poses;   ///< ... which needs these, up to the last frame ...
  std::unique_ptr<OwnPoseFeed> own_pose_feed;  ///< ... or, in a live run, these.
  std::unique_ptr<Detector> detector;
  DetectorChoice detector_choice;  ///< What it is, as the recipe has it; with its hash.
  std::unique_ptr<EdgeDetector> edges;
  EdgeChoice edge_choice;
};

}  // namespace plumbline
