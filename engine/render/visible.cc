// SPDX-License-Identifier: Apache-2.0
#include "engine/render/visible.h"

#include <cmath>

#include "engine/base/check.h"

namespace plumbline {

std::optional<cv::Rect> ImagePart(const PinholeCamera& camera,
                                  const Eigen::Isometry3d& cam_from_object,
                                  const Eigen::AlignedBox3f& bounds, double scale, double near_m) {
  const cv::Rect whole(0, 0, camera.width, camera.height);
  Eigen::AlignedBox2d box;
  int in_front = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d point =
        cam_from_object *
        (scale *
         bounds.corner(static_cast<Eigen::AlignedBox3f::CornerType>(corner)).cast<double>());
    if (point.z() < near_m) continue;
    ++in_front;
    box.extend(camera.Project(point));
  }
  if (in_front == 0) return std::nullopt;
  if (in_front < 8) return whole;
  const Eigen::Vector2d last(camera.width, camera.height);
  const Eigen::Vector2d low = (box.min().array().floor() - 1.0).max(0.0).matrix();
  const Eigen::Vector2d high = (box.max().array().ceil() + 2.0).min(last.array()).matrix();
  if (!(high.x() > low.x() && high.y() > low.y())) return std::nullopt;
  return cv::Rect(cv::Point(static_cast<int>(low.x()), static_cast<int>(low.y())),
                  cv::Point(static_cast<int>(high.x()), static_cast<int>(high.y())));
}

std::vector<VisibleInstance> FindVisible(const PinholeCamera& camera,
                                         std::span<const RenderInstance> instances,
                                         std::span<const Eigen::AlignedBox3f> bounds_of_mesh,
                                         double near_m, cv::Rect& part) {
  std::vector<VisibleInstance> visible;
  part = {};
  for (const RenderInstance& instance : instances) {
    PLB_CHECK(instance.mesh >= 0 && static_cast<std::size_t>(instance.mesh) < bounds_of_mesh.size())
        << "no mesh " << instance.mesh;
    PLB_CHECK(instance.id >= 1 && instance.id <= 65535) << "id " << instance.id;
    const auto mesh = static_cast<std::size_t>(instance.mesh);
    if (bounds_of_mesh[mesh].isEmpty()) continue;
    const auto shown =
        ImagePart(camera, instance.cam_from_object, bounds_of_mesh[mesh], instance.scale, near_m);
    if (!shown) continue;
    part = part.empty() ? *shown : (part | *shown);
    const Eigen::Matrix4d cam_from_mesh =
        (instance.cam_from_object * Eigen::Scaling(instance.scale)).matrix();
    visible.push_back({mesh, cam_from_mesh.cast<float>(), instance.id, *shown});
  }
  return visible;
}

}  // namespace plumbline
