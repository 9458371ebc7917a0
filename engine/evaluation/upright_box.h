// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <Eigen/Geometry>

#include "engine/geometry/gravity.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// A box that stands upright and is turned about gravity.
struct UprightBox {
  std::array<Eigen::Vector2d, 4> base;  ///< Along the level axes [m], counter-clockwise.
  double bottom_m = 0, top_m = 0;       ///< Along up.

  double volume() const;
};

/// The smallest such box with the object's azimuth that holds all of the posed model's vertices.
/// @param scale  Times as large as its model.
UprightBox BoxOf(const CadModel& model, const Eigen::Isometry3d& world_from_object, double scale,
                 const UprightFrame& upright);

/// Volume of the intersection over that of the union; 0 for boxes without volume.
double Iou(const UprightBox& a, const UprightBox& b);

}  // namespace plumbline
