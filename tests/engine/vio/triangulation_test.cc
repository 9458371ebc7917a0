// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/triangulation.h"

#include <gtest/gtest.h>

#include "engine/vio/chi_square_gate.h"
#include "engine/vio/rest_detector.h"

namespace plumbline {
namespace {

class Triangulation : public testing::Test {
 protected:
  Triangulation() {
    Camera described;
    described.pinhole = {640, 480, 400, 400, 320, 240};
    camera_.emplace(described);
  }
  std::vector<Sight> SightsOf(const Eigen::Vector3d& point, double step_m) {
    std::vector<Sight> sights;
    for (int k = 0; k < 8; ++k) {
      Sight sight;
      sight.world_from_cam.translation() << step_m * k, 0.3 * step_m * k, 0;
      sight.pixel = camera_->Project(sight.world_from_cam.inverse() * point)->pixel;
      sight.ray = *camera_->Unproject(sight.pixel);
      sights.push_back(sight);
    }
    return sights;
  }
  std::optional<DistortedCamera> camera_;
  const Eigen::Vector3d point_{0.4, -0.3, 3};
};

TEST_F(Triangulation, FindsAPointWithoutNoise) {
  const auto found = Triangulate(*camera_, SightsOf(point_, 0.1), {});
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((found->point_in_world - point_).norm(), 1e-6);
}

TEST_F(Triangulation, LeavesAMismatchOut) {
  std::vector<Sight> sights = SightsOf(point_, 0.1);
  sights[3].pixel += Eigen::Vector2d(12, -9);
  sights[3].ray = *camera_->Unproject(sights[3].pixel);
  const auto found = Triangulate(*camera_, sights, {});
  ASSERT_TRUE(found.has_value());
  EXPECT_FALSE(found->used[3]);
  EXPECT_LT((found->point_in_world - point_).norm(), 1e-6);
}

TEST_F(Triangulation, RefusesWithoutParallax) {
  EXPECT_FALSE(Triangulate(*camera_, SightsOf(point_, 1e-4), {}).has_value());
  EXPECT_FALSE(Triangulate(*camera_, std::span<const Sight>(), {}).has_value());
}

TEST(ChiSquareGate, IsTheQuantileOfTables) {
  const ChiSquareGate gate(0.95);
  EXPECT_NEAR(gate(1), 3.841, 0.04 * 3.841);  // as stated in its docstring
  EXPECT_NEAR(gate(3), 7.815, 0.006 * 7.815);
  EXPECT_NEAR(gate(10), 18.307, 0.006 * 18.307);
  EXPECT_NEAR(gate(100), 124.34, 0.006 * 124.34);
}

TEST(RestDetector, TellsWanderFromShaking) {
  RestDetector shaking(2), wandering(2);
  for (int k = 0; k <= 30; ++k) {
    TrackedImage shaken{k * 50'000'000, {}}, moved{k * 50'000'000, {}};
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector2d pixel(10.0 * i, 100);
      shaken.points.push_back({i, pixel + Eigen::Vector2d(k % 2 == 0 ? 2 : -2, 0)});
      moved.points.push_back({i, pixel + Eigen::Vector2d(0.5 * k, 0)});
    }
    shaking.Add(shaken);
    wandering.Add(moved);
  }
  EXPECT_LT(*shaking.WanderWithin(1), 0.5);
  EXPECT_GT(*wandering.WanderWithin(1), 4);  // 0.5 s apart at 10 px/s
  EXPECT_FALSE(RestDetector(2).WanderWithin(1).has_value());
}

}  // namespace
}  // namespace plumbline
