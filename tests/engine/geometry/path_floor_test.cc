// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/path_floor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace plumbline {
namespace {

using Path = std::vector<std::optional<Eigen::Isometry3d>>;

template <typename At>
Path PathOf(int poses, At&& at) {
  Path path;
  for (int i = 0; i < poses; ++i) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = at(i);
    path.emplace_back(pose);
  }
  return path;
}

double Height(const Eigen::Vector4d& plane, const Eigen::Vector3d& point) {
  return plane.head<3>().dot(point) + plane[3];
}

TEST(PathFloor, OfALevelRoadLiesUnderTheCamera) {
  const Path path = PathOf(50, [](int i) { return Eigen::Vector3d(i, 0.1 * i, 3); });
  const auto floor = FloorUnderPath(path, Eigen::Vector3d::UnitZ(), 1.65);
  ASSERT_TRUE(floor.has_value());
  EXPECT_NEAR(Height(floor->floor_in_world, {20, 5, 1.35}), 0, 1e-9);
  EXPECT_NEAR(floor->std_m, 0, 1e-9);
  EXPECT_NEAR(floor->floor_in_world.head<3>().norm(), 1, 1e-12);
}

TEST(PathFloor, FollowsTheSlopeAlongTheRoadAndIsLevelAcrossIt) {
  const double slope = 0.04;
  const Path path = PathOf(100, [&](int i) { return Eigen::Vector3d(i, 0, 10 + slope * i); });
  const auto floor = FloorUnderPath(path, Eigen::Vector3d::UnitZ(), 1.5);
  ASSERT_TRUE(floor.has_value());
  const double along = -floor->floor_in_world[0] / floor->floor_in_world[2];
  // The prior of 3 % pulls by (0.03 / 0.03)^2 = 1 against 83325 m^2 of the path.
  EXPECT_NEAR(along, slope, 1e-5 * slope * 2);
  EXPECT_NEAR(floor->floor_in_world[1], 0, 1e-12);
  EXPECT_NEAR(Height(floor->floor_in_world, path[30]->translation()), 1.5, 1e-4);
}

TEST(PathFloor, WorksForAnyGravityAndSkipsMissingPoses) {
  const Eigen::Vector3d up = Eigen::Vector3d(0.1, -1, 0.2).normalized();
  const Eigen::Vector3d ahead = up.unitOrthogonal();
  Path path = PathOf(20, [&](int i) { return Eigen::Vector3d(2 * up + i * ahead); });
  path[3] = std::nullopt;
  const auto floor = FloorUnderPath(path, up, 1.2);
  ASSERT_TRUE(floor.has_value());
  EXPECT_LT((floor->floor_in_world.head<3>() - up).norm(), 1e-9);
  EXPECT_NEAR(floor->floor_in_world[3], -0.8, 1e-9);
}

TEST(PathFloor, TellsHowUnevenThePathIsAndGivesUpWhereNoPlaneDescribesIt) {
  const auto wavy = [](double height) {
    return PathOf(400, [height](int i) {
      return Eigen::Vector3d(i, 0, height * std::sin(2 * 3.14159265358979 * i / 20));
    });
  };
  const auto floor = FloorUnderPath(wavy(0.1), Eigen::Vector3d::UnitZ(), 1.65);
  ASSERT_TRUE(floor.has_value());
  EXPECT_NEAR(floor->std_m, 0.1 / std::sqrt(2.0), 1e-3);  // of whole waves
  EXPECT_FALSE(FloorUnderPath(wavy(1), Eigen::Vector3d::UnitZ(), 1.65).has_value());
  EXPECT_FALSE(FloorUnderPath(Path(5), Eigen::Vector3d::UnitZ(), 1.65).has_value());
}

}  // namespace
}  // namespace plumbline
