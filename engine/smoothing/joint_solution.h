// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "engine/mapping/particle_set.h"
#include "engine/smoothing/contact.h"

namespace plumbline {

/// What the images alone say of one object.
struct MeasuredObject {
  PoseHypothesis pose;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();  ///< Of (centre in world, azimuth).
  std::shared_ptr<const SolidModel> solid;                   ///< Null: nothing stands in its way.
  bool on_floor = false;  ///< It stands on the floor that such objects share.
};

struct JointSolution {
  std::vector<PoseHypothesis> poses;           ///< As measured, in order, moved.
  std::vector<Eigen::Matrix4d> covariances;    ///< Likewise; what contacts add is left out.
  int floor_objects = 0;                       ///< That share the floor.
  double floor_height_m = 0, floor_std_m = 0;  ///< Above the floor of `map`; else along up.
};

/// The most likely poses of all objects together: each as its images have it, all that stand on
/// the floor at one height up to `floor_std_m` of the options and what models err by, none inside
/// another. Gaussians throughout; contacts are found anew until none is left
/// (docs/algorithms/smoothing.md).
JointSolution SolveJointly(std::span<const MeasuredObject> objects, const MapFrame& map,
                           const MapperOptions& options);

}  // namespace plumbline
