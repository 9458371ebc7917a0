// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "engine/annotation/outline_model.h"
#include "engine/base/result.h"
#include "engine/geometry/mesh.h"
#include "engine/vision/model_lines.h"

namespace plumbline {

/// A scanned surface that hides what lies behind it. Immutable; share it.
class OccludingScan {
 public:
  /// Errors: kDegenerate for a scan without triangles: a point cloud hides nothing.
  static Result<std::shared_ptr<const OccludingScan>> Prepare(
      std::shared_ptr<const TriangleMesh> scan);
  const RayScene& rays() const { return rays_; }

 private:
  explicit OccludingScan(std::shared_ptr<const TriangleMesh> scan);
  std::shared_ptr<const TriangleMesh> scan_;
  RayScene rays_;
};

/// What may stand before an object: the scan and the other objects.
struct Occluders {
  struct PosedModel {
    std::shared_ptr<const OutlineModel> model;
    Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
  };
  std::shared_ptr<const OccludingScan> scan;  ///< May be null.
  std::vector<PosedModel> models;             ///< Without the object itself.
};

/// Casts rays of one camera at what may hide an object, given in depth (Z in `cam`).
class OcclusionTest {
 public:
  /// @param own        The object itself; must outlive this.
  /// @param margin_m   What is not nearer by this hides nothing.
  /// @param own_scan_m Scanned surface this near to the object is taken for the object itself.
  OcclusionTest(const Occluders& occluders, const OutlineModel& own,
                const Eigen::Isometry3d& scan_from_object, const Eigen::Isometry3d& scan_from_cam,
                double margin_m, double own_scan_m);

  /// Whether something stands before the point at `depth` on the ray (x, y, 1) of the camera.
  bool Hides(const Eigen::Vector2f& bearing, float depth) const;

 private:
  struct Body {
    const RayScene* rays;
    Eigen::Vector3f origin;    ///< The camera.
    Eigen::Matrix3f rotation;  ///< From `cam`.
  };

  std::vector<Body> bodies_;
  const RayScene* scan_ = nullptr;
  const OutlineModel& own_;
  Eigen::Isometry3f scan_from_cam_, object_from_cam_;
  float margin_m_, own_scan_m_;
};

}  // namespace plumbline
