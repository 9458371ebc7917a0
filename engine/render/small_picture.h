// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/geometry/mesh.h"

namespace plumbline {

/// Where a small picture is taken from.
struct PictureView {
  Eigen::Vector3d focus{0, 0, 0};  ///< In the middle.
  double radius_m = 1;             ///< Of the ball around the focus that fits.
  Eigen::Vector3d up{0, 0, 1};
  double azimuth_rad = 0, elevation_rad = 0.4;  ///< Of the eye, as UprightFrame counts azimuth.
};

/// Thumbnails without OpenGL, so that any thread can make them. CV_8UC3 BGR.
cv::Mat ModelPicture(const TriangleMesh& model, int width, int height);

/// A posed model over the part of a scan around it. Where the scan hides the model, the model is
/// faint.
cv::Mat PlacementPicture(const TriangleMesh& scan_part, const TriangleMesh& model,
                         const Eigen::Isometry3d& scan_from_model, const PictureView& view,
                         int width, int height);

}  // namespace plumbline
