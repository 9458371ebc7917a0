// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/precision_recall.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/base/random.h"

namespace plumbline {
namespace {

TEST(PrecisionRecall, FollowsTheStepsByHand) {
  const PrecisionRecall curve =
      PrecisionRecallOf({{0.5, "b"}, {0.9, "a"}, {0.8, ""}, {0.2, ""}}, 4);
  ASSERT_EQ(curve.points.size(), 4u);
  EXPECT_EQ(curve.points[0].threshold, 0.9);
  EXPECT_EQ(curve.points[0].precision, 1);
  EXPECT_EQ(curve.points[0].recall, 0.25);
  EXPECT_EQ(curve.points[1].precision, 0.5);
  EXPECT_NEAR(curve.points[2].precision, 2.0 / 3, 1e-12);
  EXPECT_EQ(curve.points[2].recall, 0.5);
  EXPECT_EQ(curve.points[3].precision, 0.5);
  EXPECT_NEAR(curve.average_precision, 0.25 * 1 + 0.25 * 2 / 3, 1e-12);
}

TEST(PrecisionRecall, CountsATrueObjectOnceAndEqualProbabilitiesTogether) {
  const PrecisionRecall curve = PrecisionRecallOf({{0.9, "a"}, {0.9, "a"}, {0.9, "b"}}, 2);
  ASSERT_EQ(curve.points.size(), 1u);
  EXPECT_NEAR(curve.points[0].precision, 2.0 / 3, 1e-12);
  EXPECT_EQ(curve.points[0].recall, 1);
}

TEST(PrecisionRecall, IsEmptyWithoutObjectsAndHasNoRecallWithoutTruth) {
  EXPECT_TRUE(PrecisionRecallOf({}, 3).points.empty());
  EXPECT_EQ(PrecisionRecallOf({{0.5, ""}}, 0).points.front().recall, 0);
}

TEST(LabelCalibration, IsNearZeroWhereFrequenciesAreWhatWasClaimed) {
  LabelCalibration honest, boastful;
  Random random({.seed = 3});
  constexpr int kLabels = 20'000;
  for (int i = 0; i < kLabels; ++i) {
    const double probability = random.Uniform(0.5, 1);
    const bool right = random.Uniform() < probability;
    honest.Add(probability, right);
    boastful.Add(0.5 + 0.5 * probability, right);
  }
  // Five bins of 4000: a standard deviation of at most .008 each, .8 of it expected.
  EXPECT_LT(*honest.ExpectedError(), 0.01);
  EXPECT_NEAR(honest.claimed / kLabels, 0.75, 0.01);
  EXPECT_NEAR(*boastful.ExpectedError(), 0.125, 0.012) << "mean of (1 - p) / 2";
}

TEST(LabelCalibration, PutsCertaintyIntoTheLastBinAndSaysNothingOfNothing) {
  LabelCalibration labels;
  EXPECT_FALSE(labels.ExpectedError());
  labels.Add(1, true);
  labels.Add(0.9, false);
  labels.Add(0, false);
  EXPECT_EQ(labels.bins[9].count, 2);
  EXPECT_EQ(labels.bins[0].count, 1);
  EXPECT_NEAR(*labels.ExpectedError(), (1.9 - 1) / 3, 1e-12);
}

}  // namespace
}  // namespace plumbline
