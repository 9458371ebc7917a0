// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/floor.h"
#include "engine/geometry/random_vector.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

struct Room {
  TriangleMesh scan;
  Eigen::Isometry3d scan_from_world = Eigen::Isometry3d::Identity();
};

/// A floor of 4 x 3 m, two walls, a table top of 1.4 x 0.8 m and outliers; 5 mm noise.
Room MakeRoom(std::uint64_t seed) {
  Random random({.seed = seed});
  Room room;
  const Eigen::Vector4d q = GaussianVector<4>(random);
  room.scan_from_world.linear() = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
  room.scan_from_world.translation() = Eigen::Vector3d(random.Uniform(-2, 2), 1, 3);
  const auto add = [&](const Eigen::Vector3d& corner, const Eigen::Vector3d& a,
                       const Eigen::Vector3d& b, int count) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d noise = GaussianVector<3>(random);
      const double along_b = random.Uniform(), along_a = random.Uniform();
      const Eigen::Vector3d point = corner + along_a * a + along_b * b + 0.005 * noise;
      room.scan.vertices.push_back((room.scan_from_world * point).cast<float>());
    }
  };
  add({0, 0, 0}, {4, 0, 0}, {0, 3, 0}, 24000);
  add({0, 0, 0}, {4, 0, 0}, {0, 0, 1.2}, 8000);
  add({0, 0, 0}, {0, 3, 0}, {0, 0, 1.2}, 6000);
  add({1, 1, 0.75}, {1.4, 0, 0}, {0, 0.8, 0}, 4000);
  add({1, 1, 0.02}, {1.5, 0.3, 0.2}, {-0.5, 1, 0.3}, 2000);
  return room;
}

double TiltDeg(const Room& room, const FloorPlane& floor) {
  const Eigen::Vector3d up = room.scan_from_world.linear().col(2);
  return UprightFrame(-up).Tilt(UprightFrame(-floor.up_in_scan).upright_rotation()) * 57.29578;
}

// 5 mm over 24000 points of a floor metres wide: 5 mm / (sqrt(24000) * 0.9 m) = 0.002 deg.
TEST(Floor, GrowsFromASeedAndKeepsToTheFloor) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Room room = MakeRoom(seed);
    const auto target = ScanTarget::Prepare(room.scan);
    ASSERT_TRUE(target.ok());
    const auto floor = FitFloorFrom(**target, room.scan_from_world * Eigen::Vector3d(3, 2.5, 0.01));
    ASSERT_TRUE(floor.ok()) << floor.error().message;
    EXPECT_LT(TiltDeg(room, *floor), 0.03);
    EXPECT_GT(floor->up_in_scan.dot(room.scan_from_world.linear().col(2)), 0);
    EXPECT_NEAR(floor->rmse_m, 0.005, 0.001);
    EXPECT_GT(floor->inliers.size(), 18000u);
    // The floor is at z = 0 of the world that it gives, and the walls above.
    const Eigen::Vector3d on_floor =
        floor->WorldFromScan() * room.scan_from_world * Eigen::Vector3d(2, 2, 0);
    EXPECT_NEAR(on_floor.z(), 0, 0.002);
    const Eigen::Vector3d on_wall =
        floor->WorldFromScan() * room.scan_from_world * Eigen::Vector3d(2, 0, 1);
    EXPECT_NEAR(on_wall.z(), 1, 0.003);
  }
}

TEST(Floor, IsFoundWithoutASeed) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Room room = MakeRoom(seed);
    const auto target = ScanTarget::Prepare(room.scan);
    ASSERT_TRUE(target.ok());
    const auto floor = FindFloor(**target);
    ASSERT_TRUE(floor.ok()) << floor.error().message;
    EXPECT_LT(TiltDeg(room, *floor), 0.03);
  }
}

/// A narrow strip of floor before a high bare wall, and boxes on it that are turned anyhow.
Room MakeCorridor(std::uint64_t seed) {
  Room room = MakeRoom(seed);
  room.scan.vertices.clear();
  Random random({.seed = 100 + seed});
  const auto add = [&](const Eigen::Vector3d& corner, const Eigen::Vector3d& a,
                       const Eigen::Vector3d& b) {
    const int count = static_cast<int>(2000 * a.cross(b).norm());
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d noise = GaussianVector<3>(random);
      const double along_b = random.Uniform(), along_a = random.Uniform();
      const Eigen::Vector3d point = corner + along_a * a + along_b * b + 0.004 * noise;
      room.scan.vertices.push_back((room.scan_from_world * point).cast<float>());
    }
  };
  add({0, 0, 0}, {5, 0, 0}, {0, 1.4, 0});
  add({0, 0, 0}, {5, 0, 0}, {0, 0, 2.6});
  for (int box = 0; box < 4; ++box) {
    const double turn = random.Uniform(0.2, 1.3), height = random.Uniform(0.4, 0.9);
    const Eigen::Vector3d a(0.5 * std::cos(turn), 0.5 * std::sin(turn), 0),
        b(-0.4 * std::sin(turn), 0.4 * std::cos(turn), 0), up(0, 0, height),
        corner(0.6 + 1.1 * box, 0.4, 0);
    add(corner, a, up);
    add(corner, b, up);
    add(corner + a, b, up);
    add(corner + up, a, b);
  }
  return room;
}

TEST(Floor, IsNotABareWall) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Room room = MakeCorridor(seed);
    const auto target = ScanTarget::Prepare(room.scan);
    ASSERT_TRUE(target.ok());
    const auto floor = FindFloor(**target);
    ASSERT_TRUE(floor.ok()) << floor.error().message;
    EXPECT_LT(TiltDeg(room, *floor), 0.1) << seed;
    EXPECT_TRUE(floor->guessed);
    EXPECT_LT(floor->rival, 0.5);
    FloorHints hints;
    hints.up_in_scan = floor->up_in_scan;
    EXPECT_FALSE(FindFloor(**target, hints)->guessed);
  }
}

TEST(Floor, TakesItsSideFromTheCameras) {
  const Room room = MakeRoom(1);
  const auto target = ScanTarget::Prepare(room.scan);
  ASSERT_TRUE(target.ok());
  FloorHints hints;
  hints.camera_centers = {room.scan_from_world * Eigen::Vector3d(2, 2, -1)};
  const auto floor =
      FitFloorFrom(**target, room.scan_from_world * Eigen::Vector3d(3, 2.5, 0.01), hints);
  ASSERT_TRUE(floor.ok());
  EXPECT_LT(floor->up_in_scan.dot(room.scan_from_world.linear().col(2)), -0.99);
}

TEST(Floor, AHintKeepsItFromTheTableAndTheWalls) {
  const Room room = MakeRoom(2);
  const auto target = ScanTarget::Prepare(room.scan);
  ASSERT_TRUE(target.ok());
  FloorHints hints;
  hints.up_in_scan = (room.scan_from_world.linear() * Eigen::Vector3d(0.3, 0.2, 1)).normalized();
  const auto floor = FindFloor(**target, hints);
  ASSERT_TRUE(floor.ok());
  EXPECT_LT(TiltDeg(room, *floor), 0.03);
}

TEST(Floor, RefusesASeedAwayFromTheScan) {
  const Room room = MakeRoom(3);
  const auto target = ScanTarget::Prepare(room.scan);
  ASSERT_TRUE(target.ok());
  const auto floor = FitFloorFrom(**target, room.scan_from_world * Eigen::Vector3d(3.5, 0.8, 0.4));
  ASSERT_FALSE(floor.ok());
  EXPECT_EQ(floor.error().code, ErrorCode::kDegenerate);
}

TEST(Floor, CamerasHeldUprightShowUp) {
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 10; ++i) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Eigen::Matrix3d level;  // x right, y down, z forward in a z-up world
    level << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    pose.linear() = Eigen::AngleAxisd(0.6 * i, Eigen::Vector3d::UnitZ()) * level;
    poses.push_back(pose);
  }
  const auto up = UpOfCameras(poses);
  ASSERT_TRUE(up.has_value());
  EXPECT_LT((*up - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_FALSE(UpOfCameras({}).has_value());
}

}  // namespace
}  // namespace plumbline
