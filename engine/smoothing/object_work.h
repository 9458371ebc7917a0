// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "engine/annotation/image_refinement.h"
#include "engine/smoothing/lookback.h"
#include "engine/smoothing/object_views.h"

namespace plumbline {

/// An object on its way through the second pass.
struct ObjectWork {
  ObjectReport causal;
  MapObject object;
  std::vector<ObjectSight> sights;
  std::vector<std::size_t> views;  ///< Of `sights`, the best one first.
  Presence presence;
  bool kept = false;  ///< It is there.
  std::optional<ImageRefinement> refined;
  PoseHypothesis pose;                                       ///< The best so far.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();  ///< Of (centre in world, azimuth).
};

/// The frames that objects are seen in, by number; without search tables.
using FrameInputs = std::map<int, MapperInput>;

}  // namespace plumbline
