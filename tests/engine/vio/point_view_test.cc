// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/point_view.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/vio/filter_state.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

constexpr double kTinyStep = 1e-6;
using PoseError = Eigen::Matrix<double, 6, 1>;

Camera SomeCamera(CameraModel model, std::vector<double> distortion) {
  Camera camera;
  camera.model = model;
  camera.pinhole = {640, 480, 400, 398, 322, 238};
  camera.distortion = std::move(distortion);
  return camera;
}

Eigen::Isometry3d SomePose(const Eigen::Vector3d& turn, const Eigen::Vector3d& place) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = RotationExp(turn);
  pose.translation() = place;
  return pose;
}

/// R = Exp(theta) R^, p = p^ + d.
Eigen::Isometry3d WithCameraError(const Eigen::Isometry3d& body_from_cam, const PoseError& error) {
  return SomePose({0, 0, 0}, error.tail<3>() + body_from_cam.translation()) *
         Eigen::Isometry3d(RotationExp(error.head<3>()) * body_from_cam.linear());
}

const Eigen::Isometry3d kBodyFromCam = SomePose({0.1, -0.2, 1.5}, {0.05, -0.03, 0.02});
const Eigen::Isometry3d kWorldFromBody = SomePose({0.5, 0.3, -0.4}, {3, -2, 1});
const Eigen::Vector3d kPoint = kWorldFromBody * (kBodyFromCam * Eigen::Vector3d(0.7, -0.4, 2.5));

TEST(PointView, EveryJacobianIsTheNumericalDerivative) {
  const Camera cameras[] = {SomeCamera(CameraModel::kPinhole, {}),
                            SomeCamera(CameraModel::kRadialTangential, {-0.28, 0.07, 2e-4, 2e-5}),
                            SomeCamera(CameraModel::kEquidistant, {0.003, 0.0007, -0.002, 0.0002}),
                            SomeCamera(CameraModel::kFov, {0.93})};
  for (const Camera& described : cameras) {
    const DistortedCamera camera(described);
    const PointView view = *ViewPoint(camera, kBodyFromCam, kWorldFromBody, kPoint);
    for (int i = 0; i < 6; ++i) {
      const PoseError d = kTinyStep * PoseError::Unit(i);
      const auto by_pose = [&](const PoseError& e) {
        return ViewPoint(camera, kBodyFromCam, Moved(kWorldFromBody, e), kPoint)->pixel;
      };
      const auto by_camera = [&](const PoseError& e) {
        return ViewPoint(camera, WithCameraError(kBodyFromCam, e), kWorldFromBody, kPoint)->pixel;
      };
      // Relative to derivatives of some hundred pixels.
      EXPECT_LT(((by_pose(d) - by_pose(-d)) / (2 * kTinyStep) - view.by_pose.col(i)).norm(), 1e-4);
      EXPECT_LT(((by_camera(d) - by_camera(-d)) / (2 * kTinyStep) - view.by_camera.col(i)).norm(),
                1e-4);
    }
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = kTinyStep * Eigen::Vector3d::Unit(i);
      const auto moved = [&](const Eigen::Vector3d& e) {
        return ViewPoint(camera, kBodyFromCam, kWorldFromBody, kPoint + e)->pixel;
      };
      EXPECT_LT(((moved(d) - moved(-d)) / (2 * kTinyStep) - view.by_point.col(i)).norm(), 1e-4);
    }
  }
}

TEST(PointView, APointOnItsAnchorMovesAsItsJacobiansSay) {
  const Eigen::Vector3d value(0.3, -0.2, 0.4);
  const AnchoredPoint placed = PlacePoint(kBodyFromCam, kWorldFromBody, value);
  for (int i = 0; i < 6; ++i) {
    const PoseError d = kTinyStep * PoseError::Unit(i);
    const auto by_anchor = [&](const PoseError& e) {
      return PlacePoint(kBodyFromCam, Moved(kWorldFromBody, e), value).point_in_world;
    };
    const auto by_camera = [&](const PoseError& e) {
      return PlacePoint(WithCameraError(kBodyFromCam, e), kWorldFromBody, value).point_in_world;
    };
    EXPECT_LT(((by_anchor(d) - by_anchor(-d)) / (2 * kTinyStep) - placed.by_anchor.col(i)).norm(),
              1e-8);
    EXPECT_LT(((by_camera(d) - by_camera(-d)) / (2 * kTinyStep) - placed.by_camera.col(i)).norm(),
              1e-8);
  }
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = kTinyStep * Eigen::Vector3d::Unit(i);
    const auto moved = [&](const Eigen::Vector3d& e) {
      return PlacePoint(kBodyFromCam, kWorldFromBody, MovedPoint(value, e)).point_in_world;
    };
    EXPECT_LT(((moved(d) - moved(-d)) / (2 * kTinyStep) - placed.by_value.col(i)).norm(), 1e-7);
  }
}

TEST(PointView, AnotherChartIsTheSamePointAndMovesAsItsJacobiansSay) {
  const PointChart chart = *ChartPoint(kBodyFromCam, kWorldFromBody, kPoint);
  EXPECT_LT(
      (PlacePoint(kBodyFromCam, kWorldFromBody, chart.bearing_and_inverse_depth).point_in_world -
       kPoint)
          .norm(),
      1e-12);
  for (int i = 0; i < 6; ++i) {
    const PoseError d = kTinyStep * PoseError::Unit(i);
    const auto logarithmic = [](const Eigen::Vector3d& value) {
      return Eigen::Vector3d(value.x(), value.y(), std::log(value.z()));
    };
    const auto by_anchor = [&](const PoseError& e) {
      return logarithmic(
          ChartPoint(kBodyFromCam, Moved(kWorldFromBody, e), kPoint)->bearing_and_inverse_depth);
    };
    const auto by_camera = [&](const PoseError& e) {
      return logarithmic(ChartPoint(WithCameraError(kBodyFromCam, e), kWorldFromBody, kPoint)
                             ->bearing_and_inverse_depth);
    };
    EXPECT_LT(((by_anchor(d) - by_anchor(-d)) / (2 * kTinyStep) - chart.by_anchor.col(i)).norm(),
              1e-8);
    EXPECT_LT(((by_camera(d) - by_camera(-d)) / (2 * kTinyStep) - chart.by_camera.col(i)).norm(),
              1e-8);
  }
}

TEST(PointView, MovingEverythingTogetherIsNotSeen) {
  // A turn about any axis and a translation of pose and point: columns of the gauge.
  const DistortedCamera camera(SomeCamera(CameraModel::kRadialTangential, {-0.28, 0.07, 0, 0}));
  const PointView view = *ViewPoint(camera, kBodyFromCam, kWorldFromBody, kPoint);
  Eigen::Matrix<double, 2, 6> of_point;  // p moves by phi x p + xi
  of_point << -view.by_point * Hat(kPoint), view.by_point;
  EXPECT_LT((view.by_pose + of_point).norm(), 1e-9);
}

}  // namespace
}  // namespace plumbline
