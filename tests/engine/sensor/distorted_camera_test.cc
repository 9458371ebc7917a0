// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/distorted_camera.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "engine/base/random.h"

namespace plumbline {
namespace {

/// One camera of each model, as real ones are: none, EuRoC cam0, TUM-VI cam0, a Tango tablet.
std::vector<Camera> Cameras() {
  std::vector<Camera> cameras(4);
  cameras[0].pinhole = {640, 480, 511, 514, 324.7, 251.9};
  cameras[1] = {CameraModel::kRadialTangential,
                {752, 480, 458.654, 457.296, 367.215, 248.375},
                {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
  cameras[2] = {CameraModel::kEquidistant,
                {512, 512, 190.978, 190.973, 254.932, 256.897},
                {0.0034824, 0.00071503, -0.0020532, 0.00020294}};
  cameras[3] = {
      CameraModel::kFov, {640, 480, 257.672, 258.156, 327.734, 229.112}, {0.932489670230815}};
  return cameras;
}

cv::Matx33d Intrinsics(const PinholeCamera& c) { return {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1}; }

/// A point 0.5 to 5 m away, at most `angle` from the axis.
Eigen::Vector3d RandomPoint(Random& random, double angle) {
  const double from_axis = random.Uniform(0, angle), around = random.Uniform(0, 6.28);
  return random.Uniform(0.5, 5) * Eigen::Vector3d(std::sin(from_axis) * std::cos(around),
                                                  std::sin(from_axis) * std::sin(around),
                                                  std::cos(from_axis));
}

TEST(DistortedCamera, ProjectsAsOpenCvDoes) {
  Random random({.seed = 1});
  const Camera radial = Cameras()[1], fisheye = Cameras()[2];
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p = RandomPoint(random, 0.7);
    std::vector<cv::Point2d> expected;
    cv::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, cv::Vec3d(), cv::Vec3d(),
                      Intrinsics(radial.pinhole), radial.distortion, expected);
    const auto pixel = DistortedCamera(radial).Project(p)->pixel;
    EXPECT_NEAR(pixel.x(), expected[0].x, 1e-9);
    EXPECT_NEAR(pixel.y(), expected[0].y, 1e-9);
  }
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p = RandomPoint(random, 1.5);
    std::vector<cv::Point2d> expected;
    cv::fisheye::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, expected,
                               cv::Vec3d(), cv::Vec3d(), Intrinsics(fisheye.pinhole),
                               fisheye.distortion);
    const auto pixel = DistortedCamera(fisheye).Project(p)->pixel;
    EXPECT_NEAR(pixel.x(), expected[0].x, 1e-9);
    EXPECT_NEAR(pixel.y(), expected[0].y, 1e-9);
  }
}

TEST(DistortedCamera, FollowsTheClosedFormOfTheFovModel) {
  const Camera camera = Cameras()[3];
  const double w = camera.distortion[0];
  Random random({.seed = 2});
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p = RandomPoint(random, 1.3);
    const double r_u = std::hypot(p.x(), p.y()) / p.z();
    const double r_d = std::atan(2 * r_u * std::tan(w / 2)) / w;
    const auto pixel = DistortedCamera(camera).Project(p)->pixel;
    EXPECT_NEAR(pixel.x(), camera.pinhole.fx * p.x() / p.z() * r_d / r_u + camera.pinhole.cx, 1e-9);
    EXPECT_NEAR(pixel.y(), camera.pinhole.fy * p.y() / p.z() * r_d / r_u + camera.pinhole.cy, 1e-9);
  }
}

TEST(DistortedCamera, UnprojectsWhatItProjects) {
  Random random({.seed = 3});
  for (const Camera& camera : Cameras()) {
    const DistortedCamera lens(camera);
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d ray = RandomPoint(random, 0.98 * lens.max_angle_rad()).normalized();
      const auto projection = lens.Project(ray);
      ASSERT_TRUE(projection) << CameraModelName(camera.model);
      const auto back = lens.Unproject(projection->pixel);
      // At a margin where the tangential part folds, another ray may share the pixel.
      if (!back && std::acos(ray.z()) > 0.9 * lens.max_angle_rad()) continue;
      ASSERT_TRUE(back) << CameraModelName(camera.model) << " " << ray.transpose();
      EXPECT_LT((*back - ray).norm(), 1e-9)
          << CameraModelName(camera.model) << " " << ray.transpose();
      EXPECT_NEAR(back->norm(), 1, 1e-12);
    }
  }
}

TEST(DistortedCamera, UnprojectsEveryPixelOfItsImage) {
  for (const Camera& camera : Cameras()) {
    const DistortedCamera lens(camera);
    for (int v = 0; v < camera.pinhole.height; v += 20) {
      for (int u = 0; u < camera.pinhole.width; u += 20) {
        const auto ray = lens.Unproject(Eigen::Vector2d(u, v));
        ASSERT_TRUE(ray) << CameraModelName(camera.model) << " " << u << " " << v;
        EXPECT_LT((lens.Project(*ray)->pixel - Eigen::Vector2d(u, v)).norm(), 1e-9);
      }
    }
  }
}

TEST(DistortedCamera, DerivativeIsThatOfCentralDifferences) {
  Random random({.seed = 4});
  for (const Camera& camera : Cameras()) {
    const DistortedCamera lens(camera);
    for (int i = 0; i < 300; ++i) {
      Eigen::Vector3d point = RandomPoint(random, 0.9 * lens.max_angle_rad());
      if (i == 0) point << 0, 0, 2;
      if (i == 1) point << 1e-12, -2e-12, 2;
      Eigen::Matrix<double, 2, 3> numeric;
      for (int axis = 0; axis < 3; ++axis) {
        const double h = 1e-6 * point.norm();
        const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
        numeric.col(axis) =
            (lens.Project(point + step)->pixel - lens.Project(point - step)->pixel) / (2 * h);
      }
      const auto analytic = lens.Project(point)->pixel_by_point;
      EXPECT_LT((analytic - numeric).norm(), 1e-6 * (1 + analytic.norm()))
          << CameraModelName(camera.model) << " at " << point.transpose() << "\n"
          << analytic << "\nnumeric\n"
          << numeric;
    }
  }
}

TEST(DistortedCamera, DerivativeByTheIntrinsicsIsThatOfCentralDifferences) {
  Random random({.seed = 5});
  for (const Camera& camera : Cameras()) {
    const DistortedCamera lens(camera);
    const auto values = lens.intrinsics();
    EXPECT_EQ(values[0], camera.pinhole.fx);
    EXPECT_EQ(values[3], camera.pinhole.cy);
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d point = RandomPoint(random, 0.8 * lens.max_angle_rad());
      Eigen::Matrix<double, 2, 8> numeric = Eigen::Matrix<double, 2, 8>::Zero();
      for (int k = 0; k < 4 + std::min<int>(4, static_cast<int>(camera.distortion.size())); ++k) {
        const double h = 1e-5;
        DistortedCamera::Intrinsics more = values, less = values;
        more[k] += h;
        less[k] -= h;
        numeric.col(k) =
            (lens.With(more).Project(point)->pixel - lens.With(less).Project(point)->pixel) /
            (2 * h);
      }
      const auto analytic = lens.PixelByIntrinsics(point);
      EXPECT_LT((analytic - numeric).norm(), 1e-5 * (1 + analytic.norm()))
          << CameraModelName(camera.model) << " at " << point.transpose();
    }
  }
}

TEST(DistortedCamera, IsContinuousAcrossTheAxis) {
  for (const Camera& camera : Cameras()) {
    const DistortedCamera lens(camera);
    const auto on = lens.Project({0, 0, 2}), beside = lens.Project({1e-7, -1e-7, 2});
    EXPECT_EQ(on->pixel, Eigen::Vector2d(camera.pinhole.cx, camera.pinhole.cy));
    EXPECT_LT((on->pixel - beside->pixel).norm(), 1e-4);
    EXPECT_LT((on->pixel_by_point - beside->pixel_by_point).norm(), 1e-4);
    EXPECT_LT((*lens.Unproject(on->pixel) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);
  }
}

TEST(DistortedCamera, HasNoPixelWhereItsModelDoesNotHold) {
  for (const Camera& camera : Cameras()) {
    const DistortedCamera lens(camera);
    const bool sees_behind = camera.model == CameraModel::kEquidistant;
    EXPECT_EQ(lens.Project({1, 0, -0.1}).has_value(), sees_behind) << CameraModelName(camera.model);
    EXPECT_FALSE(lens.Project({0, 0, -1}) && !sees_behind);
    EXPECT_FALSE(lens.Project({0, 0, 0}));
  }
  // A barrel lens whose polynomial turns back at r = 1 / sqrt(3 * 0.3): rays beyond would land in
  // the image again.
  Camera folding = Cameras()[1];
  folding.distortion = {-0.3, 0, 0, 0};
  const DistortedCamera lens(folding);
  EXPECT_NEAR(lens.max_angle_rad(), std::atan(1 / std::sqrt(0.9)), 1e-9);
  EXPECT_TRUE(lens.Project({1.05, 0, 1}));
  EXPECT_FALSE(lens.Project({1.06, 0, 1}));
  EXPECT_FALSE(lens.Unproject({4000, 240}));
}

}  // namespace
}  // namespace plumbline
