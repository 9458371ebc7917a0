// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "engine/geometry/mesh.h"
#include "engine/vision/viewpoint_model.h"

namespace plumbline {

/// Casts rays at one mesh, which must outlive it.
class RayScene {
 public:
  explicit RayScene(const TriangleMesh& mesh);
  ~RayScene();

  struct Hit {
    float distance = 0;  ///< In lengths of the direction; 0 none.
    Eigen::Vector3f normal{0, 0, 0};
    float luminance = kUnknownLuminance;  ///< 0 .. 1.
  };
  Hit Cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;

 private:
  struct Embree;
  const TriangleMesh& mesh_;
  std::unique_ptr<Embree> embree_;
};

/// A pinhole camera around the object; directions have z = 1 in the camera, so a hit's distance is
/// its depth.
struct ViewCamera {
  Eigen::Vector3f origin, right, down, forward;
  float pixel = 0;  ///< Size of a pixel at depth 1.
  int size = 0;

  Eigen::Vector3f Direction(float u, float v) const {
    const float c = 0.5f * (size - 1);
    return forward + (u - c) * pixel * right + (v - c) * pixel * down;
  }
};

/// A camera at `distance` [m] from the centre, in the direction `from_center`, that looks at the
/// centre and holds the bounding sphere.
ViewCamera CameraAt(const Eigen::Vector3f& center, const Eigen::Vector3f& from_center,
                    float distance, float radius, int size);

/// What a camera sees of a model's lines.
struct ModelLines {
  std::vector<ContourPoint> points;  ///< Those of the contour first.
  int outline_size = 0;
  double length_px = 0;  ///< All together, inner lines weighted.
};

/// About `options.points` points evenly spaced along contour (depth steps of `step` [m]) and inner
/// lines.
ModelLines SampleLines(const RayScene& scene, const ViewCamera& camera, float step,
                       const ViewpointModelOptions& options);

}  // namespace plumbline
