// SPDX-License-Identifier: Apache-2.0
// What the evaluation of the original VISMA tools gets wrong, one test each. Its sampler's faults
// (triangle k drawn for the interval of k + 1, points outside their triangle, seed from the clock)
// are in surface_sampling_test.cc.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "tests/engine/evaluation/test_scene.h"

namespace plumbline {
namespace {

MapEvaluation EvaluateSeeded(const std::vector<EstimatedObject>& map, const GroundTruth& truth,
                             std::uint64_t seed = 0) {
  EvaluationOptions options;
  options.samples = 5000;
  options.seed = seed;
  Result<MapEvaluation> result = EvaluateMap(map, truth, *TestDatabase(), nullptr, options);
  PLB_CHECK(result.ok()) << result.error().message;
  return std::move(*result);
}

GroundTruth TwoChairs(double apart_m) {
  GroundTruth truth;
  truth.instances = {{"left", "chair", "chair", UprightPose(0, 0, 0, 0), true},
                     {"right", "chair", "chair", UprightPose(apart_m, 0, 0, 0), true}};
  return truth;
}

TEST(OriginalTraps, EachMatchCountsOnce) {
  // Both truths lie within reach of both estimates: the original adds an entry for every remaining
  // truth.
  const GroundTruth truth = TwoChairs(0.3);
  std::vector<EstimatedObject> map = PerfectMap(truth);
  for (EstimatedObject& object : map) object.world_from_object.translation().y() = 0.1;
  const MapEvaluation evaluation = EvaluateSeeded(map, truth);
  EXPECT_EQ(evaluation.matched.size(), 2u);
  EXPECT_NEAR(*evaluation.mean.translation_m, 0.1, 1e-9);
}

TEST(OriginalTraps, TwoEstimatesDoNotShareAnInstance) {
  const GroundTruth truth = TwoChairs(3);
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[1].world_from_object = UprightPose(0.05, 0, 0, 0);
  const MapEvaluation evaluation = EvaluateSeeded(map, truth);
  ASSERT_EQ(evaluation.matched.size(), 1u);
  EXPECT_EQ(evaluation.matched[0].estimate.id, "1");
  ASSERT_EQ(evaluation.spurious.size(), 1u);
  EXPECT_EQ(evaluation.spurious[0].estimate.id, "2");
  ASSERT_EQ(evaluation.missed.size(), 1u);
  EXPECT_EQ(evaluation.missed[0].id, "right");
}

TEST(OriginalTraps, TheBestPairsWinNotTheFirst) {
  // The first estimate is nearer to 'left', but only so can both be matched.
  const GroundTruth truth = TwoChairs(0.6);
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(0.2, 0, 0, 0);
  map[1].world_from_object = UprightPose(-0.3, 0, 0, 0);
  const MapEvaluation evaluation = EvaluateSeeded(map, truth);
  ASSERT_EQ(evaluation.matched.size(), 2u);
  EXPECT_EQ(evaluation.matched[0].truth.id, "right");
  EXPECT_EQ(evaluation.matched[1].truth.id, "left");
}

TEST(OriginalTraps, AnObjectOfAnotherCategoryIsNoMatch) {
  GroundTruth truth = TwoChairs(3);
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].model = "mug";
  map[0].category = "cup";
  const MapEvaluation evaluation = EvaluateSeeded(map, truth);
  EXPECT_EQ(evaluation.matched.size(), 1u);
  EXPECT_EQ(evaluation.spurious.size(), 1u);
  EXPECT_EQ(evaluation.missed.size(), 1u);
}

TEST(OriginalTraps, AnotherModelOfTheCategoryIsAMatchWithTheWrongModel) {
  const GroundTruth truth = TwoChairs(3);
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].model = "stool";
  const MapEvaluation evaluation = EvaluateSeeded(map, truth);
  ASSERT_EQ(evaluation.matched.size(), 2u);
  EXPECT_FALSE(evaluation.matched[0].model_correct);
  EXPECT_TRUE(evaluation.matched[1].model_correct);
  EXPECT_GT(evaluation.matched[0].surface.mean_m, 0.001);
}

TEST(OriginalTraps, HalfAMetreIsTheLimit) {
  const GroundTruth truth = TwoChairs(3);
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(-0.499, 0, 0, 0);
  map[1].world_from_object = UprightPose(3.501, 0, 0, 0);
  const MapEvaluation evaluation = EvaluateSeeded(map, truth);
  ASSERT_EQ(evaluation.matched.size(), 1u);
  EXPECT_EQ(evaluation.matched[0].truth.id, "left");
  EXPECT_EQ(evaluation.missed.size(), 1u);
  EXPECT_EQ(evaluation.spurious.size(), 1u);
}

TEST(OriginalTraps, DegreesAreExact) {
  const GroundTruth truth = TwoChairs(3);
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(0, 0, 0, 90);  // 180/3.14 makes 90.0456 of it
  const nlohmann::json json = EvaluationToJson(EvaluateSeeded(map, truth), {});
  EXPECT_NEAR(json["objects"][0]["rotation_deg"].get<double>(), 90, 1e-9);
  EXPECT_NEAR(json["objects"][0]["azimuth_deg"].get<double>(), 90, 1e-9);
}

TEST(OriginalTraps, TheSameSeedGivesTheSameFigures) {
  const GroundTruth truth = TestTruth();
  std::vector<EstimatedObject> map = PerfectMap(truth);
  map[0].world_from_object = UprightPose(1.05, 0.02, 0.01, 39);
  const std::string first = EvaluationToJson(EvaluateSeeded(map, truth), {}).dump();
  EXPECT_EQ(EvaluationToJson(EvaluateSeeded(map, truth), {}).dump(), first);
  EXPECT_NE(EvaluationToJson(EvaluateSeeded(map, truth, 1), {}).dump(), first);
}

}  // namespace
}  // namespace plumbline
