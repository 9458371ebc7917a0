// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "engine/registration/constrained_fit.h"
#include "engine/registration/icp.h"

namespace plumbline {

/// The scan around a placement as a coarse grid of "is there surface here that faces this way", in
/// which thousands of placements can be tried before any is refined. Immutable; share it.
class PlacementGrid {
 public:
  PlacementGrid(const AlignmentCrop& crop, const ModelSurface& model,
                const Eigen::Isometry3d& scan_from_model, const Eigen::Vector3d& up_in_scan,
                double search_m, FreeMotion motion);

  /// The start turned by `turn_rad` about up and moved, as `motion` allows and by at most
  /// `search_m`, to where most of the model's surface meets scan. Good to about 4 cm. With `rise_m`
  /// it is moved along up by that, exactly, whatever the motion allows.
  Eigen::Isometry3d BestPlacement(double turn_rad,
                                  std::optional<double> rise_m = std::nullopt) const;

 private:
  static constexpr int kDirections = 10;  ///< Up, down and eight around.
  static constexpr double kCell_m = 0.04;

  int Direction(const Eigen::Vector3d& normal_in_grid) const;
  void Splat(const Eigen::Vector3d& point_in_grid, const Eigen::Vector3d& normal_in_grid,
             bool two_sided);

  const ModelSurface& model_;
  Eigen::Isometry3d start_;
  Eigen::Vector3d up_;
  Eigen::Matrix3d grid_from_scan_;  ///< About the start's origin.
  double search_m_;
  FreeMotion motion_;
  Eigen::Vector3i size_{0, 0, 0};
  Eigen::Vector3d corner_{0, 0, 0};  ///< Centre of the first cell, in the grid's axes [m].
  std::vector<std::uint8_t> cells_;  ///< Direction, then z, y, x.
};

}  // namespace plumbline
