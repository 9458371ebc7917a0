// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"
#include "engine/models/file_frame.h"

namespace plumbline {

/// What the guesses of up and front look at, in the units and axes of the file.
struct ShapeMeasures {
  Eigen::AlignedBox3d bounds;
  Eigen::Vector3d centroid{0, 0, 0};      ///< Of the surface.
  std::vector<Eigen::Vector3d> points;    ///< On the surface, uniform by area.
  std::vector<Eigen::Vector3d> normals;   ///< There, by the order of the corners.
  std::vector<Eigen::Vector3d> vertices;  ///< Of the faces.
  /// Of the area, within 8 degrees of perpendicular to an axis.
  std::array<double, 3> flat_share{};
  /// Mean distance of the mirror image, in diagonals, per axis.
  std::array<double, 3> asymmetry{};
};

/// Errors: kDegenerate for a mesh without area.
Result<ShapeMeasures> MeasureShape(const TriangleMesh& mesh);

/// How an object stands when an axis points up.
struct Stand {
  double tipping_rad = 0;  ///< The tilt that it survives.
  /// Distance of its centre from the middle of what it stands on, in radii of that.
  double imbalance = 1;
  int feet = 0;           ///< Separate pieces that touch the plane.
  double base_share = 0;  ///< The hull of what touches the plane, of that of its shadow.

  /// More pieces are the noise of a scan.
  bool has_feet() const { return feet >= 3 && feet <= 8; }
};
Stand StandOn(const ShapeMeasures& shape, const SignedAxis& up);

}  // namespace plumbline
