// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/turntable_camera.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

namespace plumbline {
namespace {

using Eigen::Vector3d;

TEST(TurntableCamera, KeepsUpUprightWhateverItDoes) {
  for (const Vector3d& up : {Vector3d(0, 0, 1), Vector3d(0, -1, 0), Vector3d(1, 0, 0),
                             Vector3d(0.3, -0.8, 0.5).normalized().eval()}) {
    TurntableCamera camera(up);
    for (int i = 0; i < 100; ++i) {
      camera.Orbit(0.37, 0.11 * std::sin(i));
      camera.Pan(0.01, -0.02);
      const Eigen::Matrix3d view = camera.view_from_world();
      EXPECT_NEAR((view * view.transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
      EXPECT_NEAR(view.determinant(), 1, 1e-12);
      EXPECT_NEAR(view.row(0).dot(up), 0, 1e-12) << "no roll";
      EXPECT_GT(view.row(1).dot(up), 0);
    }
  }
}

TEST(TurntableCamera, StopsShortOfThePoles) {
  TurntableCamera camera;
  camera.Orbit(0, 10);
  EXPECT_LT(camera.elevation_rad(), 0.5 * std::numbers::pi);
  camera.Orbit(0, -20);
  EXPECT_GT(camera.elevation_rad(), -0.5 * std::numbers::pi);
}

TEST(TurntableCamera, LooksAtItsFocusFromItsDistance) {
  TurntableCamera camera;
  camera.LookAt({1, 2, 3}, 4);
  camera.SetDirection(0, 0);
  EXPECT_NEAR((camera.eye_in_world() - Vector3d(5, 2, 3)).norm(), 0, 1e-12);
  camera.Zoom(0.5);
  EXPECT_NEAR((camera.eye_in_world() - camera.focus_in_world()).norm(), 2, 1e-12);
}

TEST(TurntableCamera, PansByTheHeightOfThePicture) {
  TurntableCamera camera;
  camera.LookAt({0, 0, 0}, 3);
  camera.SetDirection(0, 0);
  camera.Pan(0, 1);
  const double height_m = 2 * 3 * std::tan(0.5 * TurntableCamera::kViewAngle);
  EXPECT_NEAR((camera.focus_in_world() - Vector3d(0, 0, height_m)).norm(), 0, 1e-12);
}

TEST(TurntableCamera, FramesPointsTightlyFromEverywhere) {
  // A long, flat box off the origin.
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(3 + 2.0 * (i & 1), -1 + 0.8 * (i >> 1 & 1), 0.4 * (i >> 2));
  const double margin = 1.1, tangent = std::tan(0.5 * TurntableCamera::kViewAngle);
  for (const bool parallel : {false, true}) {
    for (const double aspect : {0.5, 1.0, 2.4}) {
      for (double azimuth = 0; azimuth < 6; azimuth += 0.7) {
        TurntableCamera camera;
        camera.SetParallel(parallel);
        camera.SetDirection(azimuth, 0.3 * azimuth - 0.6);
        camera.Frame(corners, aspect);
        double reach = 0;  // 1 is the edge of the picture
        Eigen::Vector2d low(9, 9), high(-9, -9);
        for (const Vector3d& corner : corners) {
          const Vector3d p = camera.view_from_world() * (corner - camera.eye_in_world());
          const double depth = parallel ? camera.distance_m() : -p.z();
          ASSERT_GT(depth, 0);
          const Eigen::Vector2d at =
              p.head<2>().cwiseQuotient(Eigen::Vector2d(aspect * tangent * depth, tangent * depth));
          low = low.cwiseMin(at);
          high = high.cwiseMax(at);
          reach = std::max(reach, at.cwiseAbs().maxCoeff());
        }
        EXPECT_NEAR(reach, 1 / margin, 1e-9) << azimuth << ", " << aspect << ", " << parallel;
        const int full = (high - low)[0] > (high - low)[1] ? 0 : 1;
        EXPECT_NEAR(low[full], -high[full], 1e-9) << "in the middle";
      }
    }
  }
}

}  // namespace
}  // namespace plumbline
