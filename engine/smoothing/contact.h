// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "engine/annotation/outline_model.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// A model with points on its surface. Immutable; share it.
struct SolidModel {
  std::shared_ptr<const OutlineModel> outline;
  std::vector<Eigen::Vector3f> surface;  ///< In `object` [m].

  /// Errors: kDegenerate for a model without triangles.
  static Result<SolidModel> Prepare(const CadModel& model);
};

/// Two objects in one place.
struct Contact {
  Eigen::Vector3d direction{0, 0, 0};  ///< Unit, horizontal, in world: in which `a` leaves `b`.
  double depth_m = 0;                  ///< By how much.
};

/// How deep `a` and `b` stand in one another: the furthest that a point of one's surface lies
/// inside the other, along the shortest horizontal way out. Inside is what surface encloses on all
/// four sides and above, so that a chair may stand under a table; what is thinner than it is wide,
/// like a seat or a table top, encloses nothing. Nothing if they are apart.
std::optional<Contact> FindContact(const SolidModel& a, const Eigen::Isometry3d& world_from_a,
                                   const SolidModel& b, const Eigen::Isometry3d& world_from_b);

}  // namespace plumbline
