// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// Of contours of models without colours, and of inner lines.
constexpr float kUnknownLuminance = -1;

/// One point of a model's contour as seen from one viewpoint, in `object` [m]. The contour is the
/// silhouette and the depth discontinuities; the point lies on the near side. Inner lines belong to
/// it with a lower weight: creases, where two faces meet at an angle, and marks, where the colours
/// of the vertices change.
struct ContourPoint {
  Eigen::Vector3f position;
  Eigen::Vector3f normal;  ///< Unit vector across the contour, from the near side outwards,
                           ///< parallel to the image plane.
  float rim = 0;  ///< Of the contour: how far inside of it, along -normal, a mark runs beside it
                  ///< [m], as the frame of a screen has it; 0 none.
  float luminance = kUnknownLuminance;  ///< Of the near side of the contour there, 0 .. 1.
};

/// The contour from one viewpoint: points evenly spaced along it, by coordinate.
struct ContourView {
  int size = 0;
  int outline_size = 0;      ///< The first of them are contour, the rest inner lines.
  const float* x = nullptr;  ///< Positions and normals in `object`, `size` each.
  const float* y = nullptr;
  const float* z = nullptr;
  const float* nx = nullptr;
  const float* ny = nullptr;
  const float* nz = nullptr;
  const float* rim = nullptr;  ///< As of ContourPoint.
  const float* luminance = nullptr;
  float length_per_point_m = 0;  ///< Contour length (of inner lines: weighted) that one point
                                 ///< stands for, measured at the object's centre depth.
};

struct ViewpointModelOptions {
  int azimuths = 48;   ///< Viewpoints around the object, 360 / n degrees apart.
  int elevations = 9;  ///< Rings of viewpoints from min to max elevation.
  double min_elevation_deg = -10, max_elevation_deg = 70;
  std::vector<double> distances = {
      1.25, 2.0, 4.0};  ///< Of the camera from the centre, in bounding radii; rising.
  int points = 256;     ///< Of each view.
  int image_px = 176;   ///< Resolution of the rays that find the contour.
  double contour_step_m =
      0.04;  ///< Depth jump that makes a contour (less for objects smaller than 13 cm).
  double inner_weight = 0.5;  ///< Of a length of crease or mark beside the same length of contour.
  double crease_angle_deg = 40;  ///< Between faces that make a crease.
  double mark_contrast = 0.15;   ///< Step of luminance (0 .. 1) that makes a mark.
  double rim_m = 0.05;           ///< A mark beside a contour by at most this is its rim.
};

/// Where the contour and the mark inside of it are so close in an image, edge detectors draw one
/// line for both, along the stronger: how much an edge along the mark counts for the contour. 1
/// where they cannot be told apart, 0 where each has a line of its own.
inline float RimWeight(float width_px) {
  constexpr float kOneLine_px = 3, kTwoLines_px = 6;
  return std::clamp((kTwoLines_px - width_px) / (kTwoLines_px - kOneLine_px), 0.0f, 1.0f);
}

/// From where a model may be seen: what stands on the floor not from below, what stands or hangs
/// higher also from there. Rings are 10 degrees apart.
ViewpointModelOptions ViewpointsOf(const CadModel& model);

/// Contours of a model precomputed for viewpoints around it, by casting rays (Embree): the same on
/// every machine. Looking up a view costs nothing; a hypothesis then costs the projection of its
/// points. Immutable; share it.
class ViewpointModel {
 public:
  /// Errors: kCancelled.
  static Result<std::shared_ptr<const ViewpointModel>> Build(const CadModel& model,
                                                             const ViewpointModelOptions& options,
                                                             const WorkContext& work);
  /// Reads the model from `cache_folder` (by content hash of mesh and options), else builds and
  /// stores it there; a cache that cannot be read or written costs only time.
  static Result<std::shared_ptr<const ViewpointModel>> LoadOrBuild(
      const CadModel& model, const ViewpointModelOptions& options,
      const std::filesystem::path& cache_folder, const WorkContext& work);

  /// What the cache keeps, behind its hash.
  std::string Encode() const;
  /// Null where the bytes are not those of a model with these options.
  static std::shared_ptr<const ViewpointModel> Decode(std::string_view bytes,
                                                      const ViewpointModelOptions& options);

  /// The precomputed view nearest to a camera at `camera_in_object` [m].
  ContourView View(const Eigen::Vector3f& camera_in_object) const;
  float bounding_radius() const { return bounding_radius_; }

 private:
  ViewpointModel() = default;
  int NumViews() const;
  /// Whether every view is a stretch of points_.
  bool IsWhole() const;

  ViewpointModelOptions options_;
  Eigen::Vector3f center_{0, 0, 0};
  float bounding_radius_ = 0;
  /// View after view: all x, all y, all z, all nx, all ny, all nz, all rims, all
  /// luminances.
  std::vector<float> points_;
  std::vector<std::int32_t> first_point_;  ///< NumViews() + 1; counts points.
  std::vector<std::int32_t> outline_size_;
  std::vector<float> length_per_point_m_;
};

}  // namespace plumbline
