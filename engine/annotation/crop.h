// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// A box that stands upright: its z axis is the crop's up, its x axis the object's front.
struct CropBox {
  Eigen::Vector3d center_in_scan{0, 0, 0};
  Eigen::Vector3d size_m{1, 1, 1};  ///< Along its own axes, > 0.
  double azimuth_rad = 0;           ///< Of its x axis, as of UprightFrame.
};

/// What lies inside a closed line that was drawn in a view, at any depth of the range.
struct CropLasso {
  Eigen::Isometry3d scan_from_cam = Eigen::Isometry3d::Identity();
  PinholeCamera camera;                     ///< Of the view; width and height do not limit it.
  std::vector<Eigen::Vector2d> polygon_px;  ///< At least 3 corners; even-odd rule.
  double near_m = 0, far_m = std::numeric_limits<double>::infinity();  ///< Along the camera's z.
  /// Of the object's front, as of UprightFrame; where there is none it lies along the footprint's
  /// smallest rectangle, on its side towards the viewer.
  std::optional<double> azimuth_rad;
};

/// A part of the scan that somebody cut out. Only the region is kept: the scan is never changed,
/// and the cut can be made again at any time.
struct Crop {
  enum class Into {
    kModel,    ///< A shape of the model database called `id`.
    kFragment  ///< Points of a VISMA folder, `id` = <model>_<N>; written by the export.
  };

  std::string id;  ///< Unique among the crops; letters, digits, '-', '_' and '.'.
  Into into = Into::kModel;
  std::string category;  ///< COCO name.
  std::variant<CropBox, CropLasso> region;
  /// Unit vector at the time of the crop; taken from the document where there is none.
  std::optional<Eigen::Vector3d> up_in_scan;
  /// Whether the surface that the object stands on is left out, and all below it.
  bool without_support = true;
  /// That surface, (a, b, c) = up, ax + by + cz + d = 0; the document's floor where there is none.
  std::optional<Eigen::Vector4d> support_in_scan;
  std::string annotator, note;
};

/// What keeps a crop from meaning anything: its name, the region's numbers. Errors: kInvalidInput.
Status CheckCrop(const Crop& crop);

/// {"id", "into": "model"|"fragment", "category", "box": {"center", "size", "azimuth"} or
/// "lasso": {"scan_from_cam", "camera": {...}, "polygon", "near", "far", "azimuth"}, "up",
/// "support": [a, b, c, d] | "auto" | "keep", "annotator", "note"}.
nlohmann::json CropToJson(const Crop& crop);
/// Errors: kInvalidInput, what is wrong with it.
Result<Crop> CropFromJson(const nlohmann::json& json);

}  // namespace plumbline
