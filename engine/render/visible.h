// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "engine/render/renderer.h"

namespace plumbline {

/// An instance that may show, and where.
struct VisibleInstance {
  std::size_t mesh = 0;
  Eigen::Matrix4f cam_from_mesh = Eigen::Matrix4f::Identity();  ///< With its scale.
  int id = 0;
  cv::Rect part;  ///< Of the image.
};

/// Those that may show, in the order given; `part` is the least rectangle that holds them all.
/// Every instance needs a mesh that there is, and an id of 1 .. 65535.
std::vector<VisibleInstance> FindVisible(const PinholeCamera& camera,
                                         std::span<const RenderInstance> instances,
                                         std::span<const Eigen::AlignedBox3f> bounds_of_mesh,
                                         double near_m, cv::Rect& part);

}  // namespace plumbline
