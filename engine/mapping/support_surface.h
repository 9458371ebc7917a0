// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/ids.h"
#include "engine/base/random.h"
#include "engine/geometry/gravity.h"
#include "engine/models/model_database.h"

namespace plumbline {

constexpr double kNoSurface = 1e-4;  ///< Chance that a mapped surface is not where it is mapped.

/// The highest level of a model on which things can stand [m, z of `object`]: where faces that look
/// up make at least half of its footprint. Nothing if there is none.
std::optional<double> SupportHeight(const CadModel& model);

/// Rectangle [x, y of `object`] around what of a model touches what it stands on: all within 2 cm
/// of its bottom.
Eigen::AlignedBox2d FootOf(const CadModel& model);

/// The flat top of a mapped object, in the axes of the upright frame.
struct SupportSurface {
  ObjectId object;               ///< Whose top it is.
  Eigen::Vector2d corner{0, 0};  ///< One of four, and where the two next to it lie from there:
  Eigen::Vector2d side_a{0, 0}, side_b{0, 0};
  double height_m = 0;
  double height_std_m = 0;

  bool Holds(const Eigen::Vector2d& point) const { return Overhang(point) <= 0; }
  /// How far a point is beyond the side that it is farthest beyond [m]; 0 for one that it holds.
  double Overhang(const Eigen::Vector2d& point) const;
  /// A point of it, all equally likely.
  Eigen::Vector3d Draw(Random& random) const;
};

SupportSurface MakeSupportSurface(const CadModel& model, double support_height_m,
                                  const Eigen::Isometry3d& world_from_object, double scale,
                                  const UprightFrame& upright, double height_std_m);

/// Where a thing stands, and how high it is, in the axes of the upright frame.
struct StandingThing {
  Eigen::Vector3d base{0, 0, 0};        ///< Middle of its bottom.
  double height_m = 0;                  ///< Of all of it.
  std::array<Eigen::Vector2d, 4> foot;  ///< Corners of FootOf.
};

/// Log density of a thing's height over that point, unnormalised, for something that stands on one
/// of the surfaces as likely as not; 0 over none of them. All of its foot stands on what it stands
/// on. Nothing reaches through a surface, and nothing hovers right above one: of what has any of
/// its foot over a surface and begins below it and ends above it, or begins less than 10 cm above
/// it, only standing on it is left, and the chance that the surface is not there.
double LogSupportPrior(const std::vector<SupportSurface>& surfaces, const StandingThing& thing);

}  // namespace plumbline
