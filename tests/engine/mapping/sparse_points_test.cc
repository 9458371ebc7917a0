// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/sparse_points.h"

#include <gtest/gtest.h>

#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

class SparsePointsTest : public testing::Test {
 protected:
  /// A wall square to the view at that depth, one point every 4 pixels.
  std::vector<Eigen::Vector3f> Wall(const Box2& box, double depth_m) const {
    std::vector<Eigen::Vector3f> points;
    for (float v = box.y0; v < box.y1; v += 4) {
      for (float u = box.x0; u < box.x1; u += 4) {
        const Eigen::Vector2d bearing = scene_.camera().Bearing({u, v});
        points.push_back((front_ * (depth_m * bearing.homogeneous())).cast<float>());
      }
    }
    return points;
  }
  double Screened(const std::vector<Eigen::Vector3f>& points, double depth_m,
                  std::span<const PlacedModel> explained = {}) const {
    return ScreenedShare(box_, depth_m, points, scene_.camera(), front_.inverse(),
                         *scene_.database(), explained);
  }

  MappingScene& scene_ = MappingScene::Get();
  const Eigen::Isometry3d front_ = LookAt({2.2, 0.6, 1.4}, {0, 0, 0.4});
  const Box2 box_{100, 60, 220, 180};
};

TEST_F(SparsePointsTest, TheMiddleOfABoxHasTheDepthOfItsPoints) {
  std::vector<Eigen::Vector3f> points = Wall(box_, 3);
  const auto depths = [&] { return DepthsInside(box_, points, scene_.camera(), front_.inverse()); };
  ASSERT_TRUE(depths().has_value());
  EXPECT_NEAR(depths()->nearest_m, 3, 1e-5);
  EXPECT_NEAR(depths()->farthest_m, 3, 1e-5);
  // One wrong point does not count, nor what is beside the box or behind the camera.
  for (const auto& wrong : {Wall({159, 119, 161, 121}, 0.5), Wall({300, 60, 330, 90}, 1),
                            Wall({120, 80, 200, 160}, -2)})
    points.insert(points.end(), wrong.begin(), wrong.end());
  EXPECT_NEAR(depths()->nearest_m, 3, 1e-5);
  EXPECT_FALSE(DepthsInside({0, 0, 40, 40}, points, scene_.camera(), front_.inverse()).has_value());
}

TEST_F(SparsePointsTest, AWallBeforeABoxScreensWhatItCovers) {
  EXPECT_DOUBLE_EQ(Screened(Wall(box_, 1), 2), 1);
  EXPECT_DOUBLE_EQ(Screened(Wall({100, 60, 160, 180}, 1), 2), 0.5);
  EXPECT_DOUBLE_EQ(Screened(Wall(box_, 3), 2), 0) << "behind it";
  EXPECT_DOUBLE_EQ(Screened(Wall(box_, 1.95), 2), 0) << "points are not that exact";
  EXPECT_DOUBLE_EQ(Screened({Wall(box_, 1).front()}, 2), 0) << "one point may be wrong";
}

TEST_F(SparsePointsTest, PointsOnMappedObjectsScreenNothing) {
  // The chair hides what is behind it already: it is drawn.
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  std::vector<Eigen::Vector3f> points;
  for (const Eigen::Vector3f& vertex : scene_.database()->model(chair.label).mesh.vertices) {
    for (int twice = 0; twice < 2; ++twice)
      points.push_back((chair.world_from_object * vertex.cast<double>()).cast<float>());
  }
  EXPECT_GT(Screened(points, 4), 0);
  EXPECT_DOUBLE_EQ(Screened(points, 4, {&chair, 1}), 0);
}

}  // namespace
}  // namespace plumbline
