// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/evaluation/object_pairs.h"
#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/point_tree.h"

namespace plumbline {

/// How near a scanned point has to be to a true object to be of it: the truth is good to 1-3 cm.
inline constexpr double kScanReach_m = 0.03;
/// How near to the place of such a point on the true object counts as scanned: thinner than most
/// boards, so that a table's underside is not taken for scanned because its top was.
inline constexpr double kScanSpacing_m = 0.01;

/// Which places on the true objects a scan has seen, decided without any estimate: points drawn on
/// the scan, put onto the nearest place of a posed true model (docs/algorithms/evaluation.md).
class ScannedSurface {
 public:
  /// @param scan  In the frame of the truth. Errors: kDegenerate without a true triangle.
  static Result<ScannedSurface> Build(const TriangleMesh& scan, std::span<const PosedModel> truth);

  /// @param place_on_truth  On the surface of a true object, in the frame of the truth [m].
  bool At(const Eigen::Vector3d& place_on_truth) const;
  /// The nearest place on a true object.
  Eigen::Vector3d Nearest(const Eigen::Vector3d& point) const { return truth_->Find(point).point; }

 private:
  ScannedSurface(std::unique_ptr<ClosestTriangleSearch> truth, std::vector<Eigen::Vector3f> places)
      : truth_(std::move(truth)), places_(std::move(places)) {}

  std::unique_ptr<ClosestTriangleSearch> truth_;
  PointTree places_;
};

}  // namespace plumbline
