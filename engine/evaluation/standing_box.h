// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <Eigen/Geometry>

#include "engine/geometry/gravity.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// A box that stands upright and is turned about gravity.
struct StandingBox {
  std::array<Eigen::Vector2d, 4> base;  ///< Along the level axes [m], counter-clockwise.
  double bottom_m = 0, top_m = 0;       ///< Along up.

  double volume() const;
};

/// The smallest such box with the object's azimuth that holds all of the posed model's vertices.
/// @param scale  Times as large as its model.
StandingBox BoxOf(const CadModel& model, const Eigen::Isometry3d& world_from_object, double scale,
                  const UprightFrame& upright);

/// A box of that length, width and height, along x, y and z of `object`, which stands on the middle
/// of its underside, as data sets tell them.
StandingBox BoxOf(const Eigen::Vector3d& size_m, const Eigen::Isometry3d& world_from_object,
                  const UprightFrame& upright);

/// The eight corners, in world.
std::array<Eigen::Vector3d, 8> CornersOf(const StandingBox& box, const UprightFrame& upright);

/// Area of the intersection of the bases over that of their union: the overlap seen from above.
double BaseIou(const StandingBox& a, const StandingBox& b);

/// Volume of the intersection over that of the union; 0 for boxes without volume.
double Iou(const StandingBox& a, const StandingBox& b);

}  // namespace plumbline
