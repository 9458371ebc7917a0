// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "engine/geometry/gravity.h"
#include "engine/mapping/map_report.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

/// Where a particle puts the centre of its model's box, and where the model's front (+x) points.
struct ParticlePlace {
  Eigen::Vector3d center_in_world;
  Eigen::Vector3d heading_in_world;  ///< Unit vector
};

/// Length of the line that shows a hypothesis' front: a third of the model's size, so that a cup
/// and a sofa read alike.
inline double NeedleLength(const ModelView* model) {
  if (model == nullptr || model->mesh == nullptr || model->mesh->empty()) return 0.15;
  return 0.33 * static_cast<double>(BoundingBox(*model->mesh).sizes().head<2>().maxCoeff());
}

inline ParticlePlace PlaceOf(const Particle& particle, const ObjectReport& object,
                             const UprightFrame& upright) {
  const double z = std::exp(static_cast<double>(particle.rho));
  return {object.world_from_reference_cam * Eigen::Vector3d(z * particle.x_c, z * particle.y_c, z),
          upright.WorldFromObjectRotation(particle.azimuth).col(0)};
}

}  // namespace plumbline
