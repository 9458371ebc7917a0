// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// An ideal camera: `cam` is x right, y down, z forward; a point of pixel (u, v) has its centre at
/// integer coordinates; u = fx X/Z + cx, v = fy Y/Z + cy.
struct PinholeCamera {
  int width = 0, height = 0;              ///< [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [px]

  Eigen::Vector2d Project(const Eigen::Vector3d& point_in_cam) const {
    return {fx * point_in_cam.x() / point_in_cam.z() + cx,
            fy * point_in_cam.y() / point_in_cam.z() + cy};
  }
  /// (X/Z, Y/Z) of a pixel.
  Eigen::Vector2d Bearing(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy};
  }
  /// The camera of the image resized by `factor` (pixel centres at integers: u' = (u + 0.5) f -
  /// 0.5).
  PinholeCamera Scaled(double factor) const;
  bool operator==(const PinholeCamera&) const = default;
};

/// How a lens bends the rays of a pinhole camera; `DistortedCamera` has the formulas.
enum class CameraModel {
  kPinhole,           ///< Not at all.
  kRadialTangential,  ///< Brown and Conrady, as in OpenCV: k1 k2 p1 p2 [k3].
  kEquidistant,       ///< Kannala and Brandt, as in cv::fisheye: k1 k2 k3 k4.
  kFov,               ///< Devernay and Faugeras: w [rad].
};

/// As camera.json names it.
std::string_view CameraModelName(CameraModel model);

/// A calibrated camera as camera.json describes it.
struct Camera {
  CameraModel model = CameraModel::kPinhole;
  /// Intrinsics of the image as recorded and, by choice, of the undistorted one.
  PinholeCamera pinhole;
  std::vector<double> distortion;  ///< As `model` orders it; empty for kPinhole.
  double rate_hz = 30.0;
  std::optional<Eigen::Isometry3d> body_from_cam;
  /// Time from the exposure of the first row to that of the last [s]; negative where the last row
  /// is read first, 0 where all are exposed at once. An image's stamp is that of its middle row.
  double rolling_shutter_s = 0;

  /// When a row is exposed, after the image's stamp [s].
  double RowDelay(double row_px) const {
    if (rolling_shutter_s == 0) return 0;
    return rolling_shutter_s * (row_px / (pinhole.height - 1) - 0.5);
  }
};

/// Errors: kUnsupported for an unknown model; kInvalidInput for missing, non-finite or non-positive
/// numbers. `file` is only for messages.
Result<Camera> CameraFromJson(const nlohmann::json& json, const std::filesystem::path& file);
nlohmann::json CameraToJson(const Camera& camera);
/// {width, height, fx, fy, cx, cy} [px].
nlohmann::json IntrinsicsToJson(const PinholeCamera& camera);

}  // namespace plumbline
