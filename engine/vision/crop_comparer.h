// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/models/model_database.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// A shape where it may be seen. point_in_cam = cam_from_object * (scale * point_in_object).
struct PosedShape {
  ModelId label;
  Eigen::Isometry3d cam_from_object = Eigen::Isometry3d::Identity();
  double scale = 1;
};

/// Says how much an image looks like shapes that may be in it: each is drawn into the image, grey
/// under a lamp at the camera, in the mean colour of what it covers, and both images are compared
/// by features that the built-in edge network finds anyway (docs/algorithms/crops.md). So it needs
/// no training for a database. Use it in one thread at a time.
class CropComparer {
 public:
  explicit CropComparer(std::shared_ptr<const ModelDatabase> database);
  ~CropComparer();

  /// What may hide the shapes: z [m], 0 none; may be smaller than the image; empty: nothing does.
  struct Occluder {
    cv::Mat depth;
    double margin_m = 0.05;  ///< It hides only what is at least this much behind it.
  };

  /// Mean cosine between the features of the image and of the image with the shape in it, where the
  /// shape shows; at most 1. Nothing for a shape that shows too little to be judged.
  /// @param bgr  CV_8UC3, of the camera's size.
  std::vector<std::optional<double>> Compare(const cv::Mat& bgr, const PinholeCamera& camera,
                                             const Occluder& occluder,
                                             std::span<const PosedShape> shapes);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plumbline
