// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/likelihood_sharpness.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

/// Views that say where something is, each off by `std_px`, of a likelihood with that curvature.
void AddViews(LikelihoodSharpness& sharpness, double std_px, double curvature, int count) {
  for (int i = 0; i < count; ++i) {
    Random random({.seed = 5, .particle = static_cast<std::uint32_t>(i)});
    const double x = curvature * std_px * random.Gaussian(),
                 y = curvature * std_px * random.Gaussian();
    sharpness.Add({x * x + y * y, 2 * curvature}, 1);
  }
}

TEST(LikelihoodSharpnessTest, NothingIsChangedBeforeAnythingIsMeasured) {
  EXPECT_DOUBLE_EQ(LikelihoodSharpness().ValueWithin(LikelihoodSharpness()), 1);
}

TEST(LikelihoodSharpnessTest, TheExponentGivesViewsTheSpreadThatTheyHave) {
  constexpr int kViews = 400;
  for (const double std_px : {0.5, 1.0}) {
    for (const double curvature : {0.5, 1.0, 2.0}) {
      LikelihoodSharpness object;
      AddViews(object, std_px, curvature, kViews);
      // The information of a view is 1 / std^2. Of 2 n squares the mean is known to 1 / sqrt(n).
      EXPECT_NEAR(object.ValueWithin(LikelihoodSharpness()) * curvature * std_px * std_px, 1,
                  4 / std::sqrt(kViews))
          << std_px << " px, curvature " << curvature;
    }
  }
}

TEST(LikelihoodSharpnessTest, AnObjectIsOneOfItsSequenceUntilItHasBeenLookedAt) {
  LikelihoodSharpness sequence, object;
  AddViews(sequence, 1, 0.5, 400);
  const double of_sequence = object.ValueWithin(sequence);
  EXPECT_NEAR(of_sequence, 2, 0.4);
  AddViews(object, 4, 0.5, 5);
  EXPECT_LT(object.ValueWithin(sequence), 0.7 * of_sequence);
  AddViews(object, 4, 0.5, 200);
  EXPECT_NEAR(object.ValueWithin(sequence), 0.2, 0.05) << "the least";
}

TEST(LikelihoodSharpnessTest, SlopesAreThoseOfTheEdgeTermInPixels) {
  MappingScene& scene = MappingScene::Get();
  const PlacedModel chair = scene.Place("chair", 0, 0, 30);
  const Eigen::Isometry3d world_from_cam = LookAt({2, 0.5, 1.4}, {0, 0, 0.4});
  const MapperInput input = scene.Input(0, world_from_cam, {&chair, 1});
  JudgingView view;
  view.view.camera = scene.camera();
  view.view.cam_from_world = world_from_cam.inverse();
  view.view.table = input.table.get();
  PoseHypothesis pose = scene.Hypothesis(chair);
  HypothesisScore score;
  scene.scorer()->Score(view.view, scene.map().upright, {&pose, 1}, {&score, 1});
  view.normalizer = EdgeNormalizer({&score, 1});
  const MapperOptions options;
  const auto slope = [&](double off_px) {
    PoseHypothesis moved = pose;
    const double depth = (view.view.cam_from_world * pose.center_in_world).z();
    moved.center_in_world += off_px * depth / 500 * world_from_cam.linear().col(0);
    return SlopeOf(*scene.scorer(), view, scene.map(), moved, options);
  };
  const ViewSlope at = slope(0), off = slope(1.5);
  EXPECT_GT(at.curvature, 0);
  // Near the peak the slope is the curvature times the way.
  EXPECT_LT(at.squared_slope, 0.1 * off.squared_slope);
  EXPECT_GT(std::sqrt(off.squared_slope), 0.2 * 1.5 * at.curvature / 2);
  EXPECT_LT(std::sqrt(off.squared_slope), 3 * 1.5 * at.curvature / 2);
}

}  // namespace
}  // namespace plumbline
