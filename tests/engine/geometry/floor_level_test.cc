// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/floor_level.h"

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "tests/support/random_pose.h"

namespace plumbline {
namespace {

TEST(FloorLevel, HoldsWhatIsOverItsOutlineForAnyGravity) {
  // An L of 2 x 2 m without the corner x, y > 1.
  const std::vector<Eigen::Vector3d> corners = {{0, 0, 0.3}, {2, 0, 0.3}, {2, 1, 0.3},
                                                {1, 1, 0.3}, {1, 2, 0.3}, {0, 2, 0.3}};
  for (std::uint32_t i = 0; i < 200; ++i) {
    Random random({.seed = 5, .particle = i});
    const Eigen::Isometry3d world_from_room = RandomPose(random);
    FloorLevel level{0.3, 0, {}};
    for (const Eigen::Vector3d& corner : corners)
      level.outline_in_world.push_back(world_from_room * corner);
    const UprightFrame upright(-world_from_room.linear().col(2));
    const Eigen::Vector3d point(random.Uniform(-0.5, 2.5), random.Uniform(-0.5, 2.5),
                                random.Uniform(-3, 3));
    const bool inside = point.x() > 0 && point.y() > 0 && point.x() < 2 && point.y() < 2 &&
                        (point.x() < 1 || point.y() < 1);
    EXPECT_EQ(Holds(level, world_from_room * point, upright), inside) << point.transpose();
  }
}

}  // namespace
}  // namespace plumbline
