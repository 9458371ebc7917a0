// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/birth.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "engine/geometry/angles.h"
#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

class BirthTest : public testing::Test {
 protected:
  std::vector<PoseHypothesis> Sample(const Detection& box, const Eigen::Isometry3d& world_from_cam,
                                     int count = 1000) {
    return SampleBirth(box, scene_.camera(), world_from_cam, scene_.map(), options_, count,
                       {.seed = 3});
  }
  /// The box of the projected bounding box, clipped to the image.
  Box2 WholeBox(const PoseHypothesis& hypothesis, const Eigen::Isometry3d& world_from_cam) {
    const Eigen::Isometry3d cam_from_object =
        world_from_cam.inverse() * scene_.map().WorldFromObject(hypothesis);
    const Eigen::AlignedBox3f& bounds = scene_.database()->model(hypothesis.label).bounds;
    Box2 box{1e9f, 1e9f, -1e9f, -1e9f};
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector2d pixel = scene_.camera().Project(
          cam_from_object *
          bounds.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i)).cast<double>());
      const auto x = static_cast<float>(pixel.x()), y = static_cast<float>(pixel.y());
      box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x), std::max(box.y1, y)};
    }
    return Intersection(box, {0, 0, static_cast<float>(scene_.camera().width - 1),
                              static_cast<float>(scene_.camera().height - 1)});
  }
  /// How many hypotheses lie within `reach_m` and `turn_deg` of the truth.
  static int Near(const std::vector<PoseHypothesis>& hypotheses, const PoseHypothesis& truth,
                  double reach_m, double turn_deg) {
    int near = 0;
    for (const PoseHypothesis& hypothesis : hypotheses) {
      near +=
          hypothesis.label == truth.label &&
          (hypothesis.center_in_world - truth.center_in_world).norm() < reach_m &&
          std::abs(WrapAngle(hypothesis.azimuth_rad - truth.azimuth_rad)) < turn_deg * kRadPerDeg;
    }
    return near;
  }

  MappingScene& scene_ = MappingScene::Get();
  MapperOptions options_;
  const Eigen::Isometry3d front_ = LookAt({2.2, 0.6, 1.4}, {0, 0, 0.4});
};

TEST_F(BirthTest, WhatStandsOnFloorsIsSpawnedOnEveryLevelOfItsPlace) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const Detection box = scene_.Boxes(front_, {&chair, 1}).front();
  MapFrame map = scene_.map();
  map.levels = {{0.3, 0, {}}};
  const auto drawn = [&] {
    return SampleBirth(box, scene_.camera(), front_, map, options_, 1000, {.seed = 3});
  };
  int floor = 0, raised = 0, between = 0;
  for (const PoseHypothesis& hypothesis : drawn()) {
    const double height = map.BaseHeight(hypothesis);
    floor += std::abs(height) < 5 * options_.floor_std_m;
    raised += std::abs(height - 0.3) < 5 * options_.floor_std_m;
    between += height > 0.1 && height < 0.2;
  }
  EXPECT_EQ(floor + raised, 1000);
  EXPECT_EQ(between, 0);
  EXPECT_GT(floor, 50);
  EXPECT_GT(raised, 50);
  // Under a platform there is no floor.
  map.levels[0].outline_in_world = {{-3, -3, 0}, {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}};
  for (const PoseHypothesis& hypothesis : drawn()) {
    const bool inside = hypothesis.center_in_world.head<2>().cwiseAbs().maxCoeff() < 3;
    EXPECT_NEAR(map.BaseHeight(hypothesis), inside ? 0.3 : 0, 5 * options_.floor_std_m);
  }
}

TEST_F(BirthTest, InformedHypothesesExplainTheBox) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const Detection box = scene_.Boxes(front_, {&chair, 1}).front();
  const std::vector<PoseHypothesis> drawn = Sample(box, front_);
  ASSERT_EQ(drawn.size(), 1000u);
  int explain = 0, armchairs = 0;
  double heights = 0;
  for (const PoseHypothesis& hypothesis : drawn) {
    EXPECT_EQ(scene_.database()->model(hypothesis.label).category, "chair");
    armchairs += hypothesis.label == scene_.Label("armchair");
    explain += Iou(WholeBox(hypothesis, front_), box.box) > 0.5f;
    heights += std::pow(scene_.map().BaseHeight(hypothesis), 2);
  }
  EXPECT_GT(explain, 700);
  EXPECT_GT(armchairs, 300) << "labels are drawn alike";
  EXPECT_LT(armchairs, 700);
  EXPECT_NEAR(std::sqrt(heights / 1000), options_.floor_std_m, 0.002);
  const PoseHypothesis truth = scene_.Hypothesis(chair);
  EXPECT_GE(Near(drawn, truth, 0.15, 180), 40) << "and some are where the object is";
  EXPECT_GE(Near(drawn, truth, 0.15, 25), 3);
}

TEST_F(BirthTest, ABoxOfThePartThatShowsMayBelongToAWholeObject) {
  // Of a chair behind a table a detector boxes the back rest.
  const PlacedModel chair = scene_.Place("chair", 0, 0, 180);
  Detection box = scene_.Boxes(front_, {&chair, 1}).front();
  box.box.y1 = 0.5f * (box.box.y0 + box.box.y1);
  const std::vector<PoseHypothesis> drawn = Sample(box, front_, 2000);
  EXPECT_GE(Near(drawn, scene_.Hypothesis(chair), 0.2, 180), 20);
}

TEST_F(BirthTest, ABoxCutByTheImageMayBelongToAWholeObject) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30);
  const Eigen::Isometry3d aside = LookAt({1.6, 0.5, 1.4}, {0.15, 0.85, 0.5});
  const Detection box = scene_.Boxes(aside, {&chair, 1}).front();
  ASSERT_TRUE(box.box.x0 <= 1 || box.box.x1 >= static_cast<float>(scene_.camera().width) - 2)
      << "the test wants a box at the border";
  const std::vector<PoseHypothesis> drawn = Sample(box, aside, 2000);
  EXPECT_GE(Near(drawn, scene_.Hypothesis(chair), 0.2, 180), 20);
}

TEST_F(BirthTest, PointsInTheBoxLimitItsDepth) {
  // Half of a suitcase that may hang anywhere: by its box alone it may be near or far.
  const Detection box{{150, 60, 230, 160}, "suitcase", 0.9f};
  MapFrame map = scene_.map();
  const auto share_between = [&](double nearest_m, double farthest_m) {
    const std::vector<PoseHypothesis> drawn =
        SampleBirth(box, scene_.camera(), front_, map, options_, 1000, {.seed = 3});
    return std::count_if(drawn.begin(), drawn.end(),
                         [&](const PoseHypothesis& hypothesis) {
                           const double depth = (front_.inverse() * hypothesis.center_in_world).z();
                           return depth > nearest_m && depth < farthest_m;
                         }) /
           1000.0;
  };
  const Eigen::Vector3d size =
      scene_.database()->model(scene_.Label("crate")).bounds.sizes().cast<double>();
  const double depth_m = 1.5, reach_m = 0.5 * size.norm();
  const double without = share_between(depth_m - reach_m, depth_m + reach_m);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector2d bearing = scene_.camera().Bearing({180.0 + 3 * i, 110});
    map.points_in_world.push_back((front_ * (depth_m * bearing.homogeneous())).cast<float>());
  }
  EXPECT_LT(without, 0.7);
  EXPECT_GT(share_between(depth_m - reach_m, depth_m + reach_m), 1 - 0.3 * (1 - without));
}

TEST_F(BirthTest, AnImplausibleBoxGivesNoHypotheses) {
  // Chairs stand on the floor: none hangs far above the horizon, none of a palm's size stands right
  // before the camera.
  const Eigen::Isometry3d level = LookAt({2, 0, 1.5}, {0, 0, 1.5});
  EXPECT_TRUE(Sample({{200, 2, 240, 40}, "chair", 0.9f}, level).empty());
  EXPECT_TRUE(Sample({{200, 340, 208, 350}, "chair", 0.9f}, level).empty());
  EXPECT_TRUE(Sample({{10, 10, 100, 100}, "elephant", 0.9f}, level).empty());
  EXPECT_TRUE(Sample({{50, 50, 50, 50}, "chair", 0.9f}, level).empty());
  // Where nothing is known of its support a thing may be there.
  EXPECT_FALSE(Sample({{200, 20, 280, 80}, "suitcase", 0.9f}, level).empty());
}

TEST_F(BirthTest, ThePapersPriorIsCentredOnTheBoxAtItsNominalDepth) {
  options_.prior = SpawnPrior::kPaper;
  const Detection box{{150, 100, 250, 260}, "chair", 0.9f};
  const int count = 4000;
  const std::vector<PoseHypothesis> drawn = Sample(box, front_, count);
  ASSERT_EQ(drawn.size(), static_cast<std::size_t>(count));
  double log_depth = 0, log_depth2 = 0, u = 0, u2 = 0, v = 0, cosine = 0;
  for (const PoseHypothesis& hypothesis : drawn) {
    const Eigen::Vector3d center = front_.inverse() * hypothesis.center_in_world;
    const Eigen::Vector2d pixel = scene_.camera().Project(center);
    log_depth += std::log(center.z()) / count;
    log_depth2 += std::pow(std::log(center.z()), 2) / count;
    u += pixel.x() / count;
    u2 += pixel.x() * pixel.x() / count;
    v += pixel.y() / count;
    cosine += std::cos(hypothesis.azimuth_rad) / count;
  }
  // Means of 4000 samples: four standard deviations.
  EXPECT_NEAR(log_depth, std::log(options_.nominal_depth_m), 4 * options_.nominal_depth_std / 63);
  EXPECT_NEAR(std::sqrt(log_depth2 - log_depth * log_depth), options_.nominal_depth_std, 0.02);
  EXPECT_NEAR(u, 200, 4 * 10.0 / 63);
  EXPECT_NEAR(std::sqrt(u2 - u * u), options_.bearing_std_boxes * 100, 0.6);
  EXPECT_NEAR(v, 180, 4 * 16.0 / 63);
  EXPECT_NEAR(cosine, 0, 4 * 0.71 / 63);
}

TEST_F(BirthTest, RepeatsForTheSameKey) {
  const Detection box{{150, 100, 250, 260}, "chair", 0.9f};
  const std::vector<PoseHypothesis> a = Sample(box, front_, 50), b = Sample(box, front_, 50);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].center_in_world, b[i].center_in_world);
}

}  // namespace
}  // namespace plumbline
