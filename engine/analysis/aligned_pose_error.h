// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "engine/sensor/pose_estimate.h"

namespace plumbline {

/// A pose as a filter tells it: what it may be off by, relative to where the filter began.
struct ToldPose {
  Eigen::Vector3d cam_in_world{0, 0, 0};
  PoseCovariance covariance = PoseCovariance::Zero();
};

/// What poses may still be off by after their positions have been aligned to the true ones in
/// heading and position (docs/algorithms/evaluation.md, *Own poses*): what all share is gone, and
/// those in the middle err least. To first order, for errors that go on from one pose to the next.
/// @param poses  By frame; nothing where a frame takes no part: its covariance is zero.
/// @param up_in_world  Of length 1.
std::vector<PoseCovariance> ErrorsAfterAlignment(std::span<const std::optional<ToldPose>> poses,
                                                 const Eigen::Vector3d& up_in_world);

}  // namespace plumbline
