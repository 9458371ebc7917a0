// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/occlusion.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/support/mapping_scene.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

class OcclusionMapsTest : public testing::Test {
 protected:
  /// Length of the contour that shows, of the whole.
  double Shown(const PlacedModel& placed, const cv::Mat& occluder_depth) {
    const MapperInput input = scene_.Input(0, front_, {});
    ScoringView view{scene_.camera(), front_.inverse(), input.table.get(), occluder_depth};
    const PoseHypothesis hypothesis = scene_.Hypothesis(placed);
    HypothesisScore score;
    scene_.scorer()->Score(view, scene_.map().upright, {&hypothesis, 1}, {&score, 1});
    return score.visible_m / score.total_m;
  }

  MappingScene& scene_ = MappingScene::Get();
  const Eigen::Isometry3d front_ = LookAt({2.2, 0.6, 1.4}, {0, 0, 0.4});
};

TEST_F(OcclusionMapsTest, NothingIsHiddenByNothing) {
  const OcclusionMaps maps;
  EXPECT_TRUE(maps.DepthBefore(ObjectId{1}).empty());
  EXPECT_TRUE(maps.DepthAndContours(ObjectId{1}).empty());
}

TEST_F(OcclusionMapsTest, AnObjectDoesNotHideItself) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30, 1);
  const OcclusionMaps maps =
      scene_.renderer().RenderOccluders(scene_.camera(), front_.inverse(), {&chair, 1});
  EXPECT_GT(Shown(chair, maps.DepthBefore(ObjectId{1})), 0.95);
}

TEST_F(OcclusionMapsTest, WhatItSinksIntoDoesNotHideIt) {
  const PlacedModel table = scene_.Place("table", 0, 0, 30, 1);
  PlacedModel crate = scene_.Place("crate", 0, 0, 30, 2);
  crate.world_from_object.translation().z() = 0.6;  // 14 cm into the top
  const OcclusionMaps maps = scene_.renderer().RenderOccluders(scene_.camera(), front_.inverse(),
                                                               std::array{table, crate});
  EXPECT_LT(Shown(crate, maps.DepthBefore(ObjectId{2})), 0.9);
  EXPECT_GT(Shown(crate, maps.DepthBefore(ObjectId{2}, ObjectId{1})), 0.95);
  EXPECT_GT(Shown(crate, maps.DepthAndContours(ObjectId{2}, ObjectId{1})),
            Shown(crate, maps.DepthAndContours(ObjectId{2})));
}

TEST_F(OcclusionMapsTest, OfAnObjectInTheLinesOfAnotherNothingIsItsOwn) {
  const PlacedModel chair = scene_.Place("chair", 0, 0, 30, 1);
  const OcclusionMaps maps =
      scene_.renderer().RenderOccluders(scene_.camera(), front_.inverse(), {&chair, 1});
  EXPECT_LT(Shown(scene_.Place("chair", 0, 0, 30, 2), maps.DepthAndContours(ObjectId{2})), 0.15);
  EXPECT_LT(Shown(scene_.Place("chair", 0.01, 0, 30, 2), maps.DepthAndContours(ObjectId{2})), 0.25);
  const PlacedModel beside = scene_.Place("chair", 0.2, -0.7, 100, 2);
  EXPECT_GT(Shown(beside, maps.DepthAndContours(ObjectId{2})),
            0.9 * Shown(beside, maps.DepthBefore(ObjectId{2})));
  EXPECT_GT(Shown(chair, maps.DepthAndContours(ObjectId{1})), 0.95) << "its own lines are its own";
}

TEST_F(OcclusionMapsTest, LinesOfRaisedThingsCanBeLeftOutAlone) {
  const PlacedModel table = scene_.Place("table", 0, 0, 30, 1);
  PlacedModel crate = scene_.Place("crate", 0, 0, 30, 2);  // it need not stand on the floor
  crate.world_from_object.translation().z() = 0.74;
  const OcclusionMaps maps = scene_.renderer().RenderOccluders(scene_.camera(), front_.inverse(),
                                                               std::array{table, crate});
  const cv::Mat& raised = maps.DepthAndContours(ObjectId{3}, {}, ContoursOf::kRaisedThings);
  EXPECT_LT(Shown(crate, raised), 0.15);
  EXPECT_GT(Shown(table, raised), 0.8 * Shown(table, maps.DepthBefore(ObjectId{3})));
  EXPECT_LT(Shown(table, maps.DepthAndContours(ObjectId{3})), 0.15);
}

TEST(LuminanceBehindTest, IsThatOfTheNearestThatIsNotTheObject) {
  std::vector<CadModel> models(2);
  for (const int i : {0, 1}) {
    const float half = i == 0 ? 0.2f : 0.6f;
    CadModel& model = models[static_cast<std::size_t>(i)];
    model.name = i == 0 ? "crate" : "board";
    model.mesh = MakeBox({-0.01f, -half, 0}, {0.01f, half, 2 * half});
    const auto grey = static_cast<std::uint8_t>(i == 0 ? 51 : 153);
    model.mesh.colors.assign(model.mesh.vertices.size(), {grey, grey, grey});
  }
  const auto database = ModelDatabase::FromModels(models);
  OcclusionRenderer renderer(*database);
  const PinholeCamera camera{640, 480, 500, 500, 319.5, 239.5};
  const Eigen::Isometry3d cam_from_world = LookAt({3, 0, 0.2}, {0, 0, 0.2}).inverse();
  std::array<PlacedModel, 2> placed{PlacedModel{ObjectId{1}, ModelId{0}},
                                    PlacedModel{ObjectId{2}, ModelId{1}}};
  placed[1].world_from_object.translation().x() = -1;
  const auto at = [](const OcclusionMaps& maps, int object, double v) {
    return maps.LuminanceBehind(ObjectId{object}).at<float>(static_cast<int>(v / 2), 160);
  };
  const OcclusionMaps both = renderer.RenderOccluders(camera, cam_from_world, placed);
  const double on_crate = 239, above_crate = 239 - 60, above_board = 5;
  EXPECT_NEAR(at(both, 1, on_crate), 0.6, 0.005);
  EXPECT_NEAR(at(both, 2, on_crate), 0.2, 0.005) << "what stands before it";
  EXPECT_NEAR(at(both, 1, above_crate), 0.6, 0.005);
  EXPECT_EQ(at(both, 2, above_crate), OcclusionMaps::kNothingBehind);
  EXPECT_NEAR(at(both, 7, on_crate), 0.2, 0.005) << "of what is not drawn";
  for (const int object : {1, 2, 7})
    EXPECT_EQ(at(both, object, above_board), OcclusionMaps::kNothingBehind);
  const OcclusionMaps alone = renderer.RenderOccluders(camera, cam_from_world, {placed.data(), 1});
  EXPECT_EQ(at(alone, 1, on_crate), OcclusionMaps::kNothingBehind);
  EXPECT_TRUE(OcclusionMaps().LuminanceBehind(ObjectId{1}).empty());
}

}  // namespace
}  // namespace plumbline
