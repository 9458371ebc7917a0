// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/point_view.h"

#include <cmath>

#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

/// A world point in the camera, and how it moves there.
struct PointInCam {
  Eigen::Vector3d point;
  Eigen::Matrix<double, 3, 6> by_pose, by_camera;
  Eigen::Matrix3d by_point;
};

PointInCam IntoCam(const Eigen::Isometry3d& body_from_cam, const Eigen::Isometry3d& world_from_body,
                   const Eigen::Vector3d& point_in_world) {
  const Eigen::Matrix3d body_from_world = world_from_body.linear().transpose();
  const Eigen::Matrix3d cam_from_body = body_from_cam.linear().transpose();
  const Eigen::Vector3d arm = body_from_world * (point_in_world - world_from_body.translation()) -
                              body_from_cam.translation();
  PointInCam result;
  result.point = cam_from_body * arm;
  result.by_point = cam_from_body * body_from_world;
  result.by_pose << result.by_point * Hat(point_in_world), -result.by_point;
  result.by_camera << cam_from_body * Hat(arm), -cam_from_body;
  return result;
}

}  // namespace

std::optional<PointView> ViewPoint(const DistortedCamera& camera,
                                   const Eigen::Isometry3d& body_from_cam,
                                   const Eigen::Isometry3d& world_from_body,
                                   const Eigen::Vector3d& point_in_world) {
  const PointInCam in_cam = IntoCam(body_from_cam, world_from_body, point_in_world);
  const std::optional<Projection> projection = camera.Project(in_cam.point);
  if (!projection) return std::nullopt;
  return PointView{projection->pixel, in_cam.point, projection->pixel_by_point * in_cam.by_pose,
                   projection->pixel_by_point * in_cam.by_camera,
                   projection->pixel_by_point * in_cam.by_point};
}

Eigen::Vector3d MovedPoint(const Eigen::Vector3d& bearing_and_inverse_depth,
                           const Eigen::Vector3d& error) {
  return {bearing_and_inverse_depth.x() + error.x(), bearing_and_inverse_depth.y() + error.y(),
          bearing_and_inverse_depth.z() * std::exp(error.z())};
}

AnchoredPoint PlacePoint(const Eigen::Isometry3d& body_from_cam,
                         const Eigen::Isometry3d& world_from_body,
                         const Eigen::Vector3d& bearing_and_inverse_depth) {
  const double depth = 1 / bearing_and_inverse_depth.z();
  const Eigen::Vector3d ray(bearing_and_inverse_depth.x(), bearing_and_inverse_depth.y(), 1);
  const Eigen::Vector3d turned = body_from_cam.linear() * (depth * ray);
  const Eigen::Matrix3d R = world_from_body.linear();
  AnchoredPoint result;
  result.point_in_world = world_from_body * (turned + body_from_cam.translation());
  result.by_anchor << -Hat(result.point_in_world), Eigen::Matrix3d::Identity();
  result.by_camera << -R * Hat(turned), R;
  Eigen::Matrix3d in_cam = Eigen::Matrix3d::Zero();
  in_cam(0, 0) = in_cam(1, 1) = depth;
  in_cam.col(2) = -depth * ray;
  result.by_value = R * body_from_cam.linear() * in_cam;
  return result;
}

std::optional<PointChart> ChartPoint(const Eigen::Isometry3d& body_from_cam,
                                     const Eigen::Isometry3d& world_from_body,
                                     const Eigen::Vector3d& point_in_world) {
  const PointInCam in_cam = IntoCam(body_from_cam, world_from_body, point_in_world);
  const double Z = in_cam.point.z();
  if (!(Z > 1e-3)) return std::nullopt;
  PointChart chart;
  chart.bearing_and_inverse_depth << in_cam.point.x() / Z, in_cam.point.y() / Z, 1 / Z;
  Eigen::Matrix3d by_cam;
  by_cam << 1 / Z, 0, -in_cam.point.x() / (Z * Z), 0, 1 / Z, -in_cam.point.y() / (Z * Z), 0, 0,
      -1 / Z;
  chart.by_anchor = by_cam * in_cam.by_pose;
  chart.by_camera = by_cam * in_cam.by_camera;
  chart.by_point = by_cam * in_cam.by_point;
  return chart;
}

}  // namespace plumbline
