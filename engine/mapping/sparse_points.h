// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/geometry/box.h"
#include "engine/mapping/occlusion.h"
#include "engine/models/model_database.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// From the nearest to the farthest [m].
struct DepthSpan {
  double nearest_m = 0, farthest_m = 0;
};

/// Depths (z in `cam`) of what the middle of a box shows, as far as points of the map tell: without
/// the nearest and the farthest tenth of those that project there. Nothing if they are too few.
std::optional<DepthSpan> DepthsInside(const Box2& box,
                                      std::span<const Eigen::Vector3f> points_in_world,
                                      const PinholeCamera& camera,
                                      const Eigen::Isometry3d& cam_from_world);

/// Share of a box that points of the map stand before, nearer than `depth_m`, of things that no
/// model explains: of 6 x 6 cells those with two points or more. Points in the bounds of
/// `explained` do not count.
double ScreenedShare(const Box2& box, double depth_m,
                     std::span<const Eigen::Vector3f> points_in_world, const PinholeCamera& camera,
                     const Eigen::Isometry3d& cam_from_world, const ModelDatabase& database,
                     std::span<const PlacedModel> explained);

}  // namespace plumbline
