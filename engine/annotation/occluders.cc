// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/occluders.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace plumbline {

OccludingScan::OccludingScan(std::shared_ptr<const TriangleMesh> scan)
    : scan_(std::move(scan)), rays_(*scan_) {}

Result<std::shared_ptr<const OccludingScan>> OccludingScan::Prepare(
    std::shared_ptr<const TriangleMesh> scan) {
  if (scan->triangles.empty()) {
    return Error{ErrorCode::kDegenerate,
                 "the scan is a point cloud without triangles: it hides nothing"};
  }
  return std::shared_ptr<const OccludingScan>(new OccludingScan(std::move(scan)));
}

OcclusionTest::OcclusionTest(const Occluders& occluders, const OutlineModel& own,
                             const Eigen::Isometry3d& scan_from_object,
                             const Eigen::Isometry3d& scan_from_cam, double margin_m,
                             double own_scan_m)
    : scan_(occluders.scan ? &occluders.scan->rays() : nullptr),
      own_(own),
      scan_from_cam_(scan_from_cam.cast<float>()),
      object_from_cam_((scan_from_object.inverse() * scan_from_cam).cast<float>()),
      margin_m_(static_cast<float>(margin_m)),
      own_scan_m_(static_cast<float>(own_scan_m)) {
  const Eigen::Isometry3f cam_from_object = object_from_cam_.inverse();
  const Eigen::Vector3f center = cam_from_object * own.center();
  for (const Occluders::PosedModel& other : occluders.models) {
    const Eigen::Isometry3f other_from_cam =
        (other.scan_from_object.inverse() * scan_from_cam).cast<float>();
    const Eigen::Vector3f other_center = other_from_cam.inverse() * other.model->center();
    const float radius = other.model->radius();
    // Behind the camera, wholly behind the object, or beside the cone that holds it.
    if (other_center.z() < -radius || other_center.norm() - radius > center.norm() + own.radius()) {
      continue;
    }
    const auto half_angle = [](const Eigen::Vector3f& middle, float size) {
      return middle.norm() <= size ? 3.2f : std::asin(size / middle.norm());
    };
    const float apart =
        std::acos(std::clamp(center.normalized().dot(other_center.normalized()), -1.0f, 1.0f));
    if (apart > half_angle(center, own.radius()) + half_angle(other_center, radius)) continue;
    bodies_.push_back(
        {&other.model->rays(), other_from_cam.translation(), other_from_cam.linear()});
  }
}

bool OcclusionTest::Hides(const Eigen::Vector2f& bearing, float depth) const {
  const Eigen::Vector3f ray(bearing.x(), bearing.y(), 1.0f);
  const float limit = depth - margin_m_;
  for (const Body& body : bodies_) {
    const float hit = body.rays->Cast(body.origin, body.rotation * ray).distance;
    if (hit > 0 && hit < limit) return true;
  }
  if (!scan_) return false;
  const float hit =
      scan_->Cast(scan_from_cam_.translation(), scan_from_cam_.linear() * ray).distance;
  if (hit <= 0 || hit >= limit) return false;
  const Eigen::Vector3f in_object = object_from_cam_ * (hit * ray);
  return !own_.surface().FindWithin(in_object.cast<double>(), own_scan_m_);
}

}  // namespace plumbline
