// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/floor_finder.h"

#include <gtest/gtest.h>

#include "engine/base/random.h"

namespace plumbline {
namespace {

/// Points at a height, spread over 2 x 2 m, as `images` images have found them.
void AddLevel(double height_m, double std_m, int points, int images, std::uint32_t key,
              FloorFinder& finder) {
  Random random({7, key});
  for (int i = 0; i < points; ++i) {
    finder.Add({random.Uniform(-1, 1), random.Uniform(-1, 1), height_m + std_m * random.Gaussian()},
               i * images / points);
  }
}

TEST(FloorFinder, FindsTheLowestOfSeveralLevels) {
  FloorFinder finder{OwnPoseOptions()};
  AddLevel(-0.6, 0.01, 400, 200, 1, finder);  // a table
  AddLevel(-1.3, 0.05, 120, 200, 2, finder);
  AddLevel(-1.8, 0.2, 8, 200, 3, finder);  // mismatches
  const auto floor = finder.Find(0.1);
  ASSERT_TRUE(floor.has_value());
  EXPECT_NEAR(floor->height_m, -1.3, 3 * floor->std_m);
  EXPECT_NEAR(floor->height_m, -1.3, 0.02) << "0.05 m over the root of 120, and some of the tails";
  EXPECT_LT(floor->std_m, 0.03);
  EXPECT_GT(floor->points, 80);
}

TEST(FloorFinder, TakesNoTableForTheFloor) {
  FloorFinder finder{OwnPoseOptions()};
  AddLevel(-0.6, 0.01, 400, 200, 1, finder);
  EXPECT_FALSE(finder.Find(0.1).has_value()) << "a camera in a hand is higher above the floor";
  OwnPoseOptions robot;
  robot.floor_camera_height_m = 0.3;
  FloorFinder low(robot);
  AddLevel(-0.6, 0.01, 400, 200, 1, low);
  EXPECT_TRUE(low.Find(0.1).has_value());
}

TEST(FloorFinder, WaitsForManyPointsFromManyImages) {
  FloorFinder few{OwnPoseOptions()}, once{OwnPoseOptions()};
  AddLevel(-1.3, 0.02, 20, 200, 1, few);
  EXPECT_FALSE(few.Find(0).has_value());
  AddLevel(-1.3, 0.02, 200, 10, 1, once);
  EXPECT_FALSE(once.Find(0).has_value()) << "one look errs as a whole";
  once.Clear();
  EXPECT_FALSE(once.Find(0).has_value());
}

TEST(FloorFinder, IsTheSurerTheMoreImagesAgree) {
  FloorFinder finder{OwnPoseOptions()};
  AddLevel(-1.3, 0.05, 100, 80, 1, finder);
  const auto early = finder.Find(0);
  AddLevel(-1.3, 0.05, 400, 800, 2, finder);
  const auto late = finder.Find(0);
  ASSERT_TRUE(early && late);
  EXPECT_LT(late->std_m, early->std_m);
}

}  // namespace
}  // namespace plumbline
