// SPDX-License-Identifier: Apache-2.0
// The figures of reference are of SciPy 1.10.
#include "engine/batch/batch_statistics.h"

#include <gmock/gmock.h>

#include "engine/base/random.h"

namespace plumbline {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

std::vector<SequenceValue> OfOneSequence(const std::vector<double>& values) {
  std::vector<SequenceValue> result;
  for (const double value : values) result.push_back({0, value});
  return result;
}

const std::vector<double> kEight = {1.2, 0.4, -0.3, 2.1, 0.9, 1.5, -0.2, 0.8};

TEST(BatchStatistics, GivesStudentsIntervalOverTheMeansOfSequences) {
  std::vector<SequenceValue> values;
  for (const double v : {3.0, 4.0, 5.0}) values.push_back({0, v});
  for (const double v : {7.0, 9.0}) values.push_back({1, v});
  for (const double v : {1.0, 2.5, 2.5, 3.0}) values.push_back({2, v});
  const auto estimate = EstimateMean(values).value();
  // stats.t.interval(.95, 2, loc=mean(m), scale=sem(m)) of the three means m
  EXPECT_NEAR(estimate.mean, 4.75, 1e-12);
  EXPECT_NEAR(estimate.low.value(), -2.5718879217777557, 1e-9);
  EXPECT_NEAR(estimate.high.value(), 12.071887921777755, 1e-9);
  EXPECT_NEAR(estimate.seed_std, 1.0206207261596576, 1e-12);
  EXPECT_NEAR(estimate.sequence_std, 2.947456530637899, 1e-12);
  EXPECT_TRUE(estimate.over_sequences);
  EXPECT_EQ(estimate.values, 9);
  EXPECT_EQ(estimate.sequences, 3);
}

TEST(BatchStatistics, GivesItOverSeedsWhereThereIsOneSequence) {
  const auto estimate = EstimateMean(OfOneSequence({3, 4, 5, 7})).value();
  EXPECT_NEAR(estimate.low.value(), 2.0324691162035107, 1e-9);
  EXPECT_NEAR(estimate.high.value(), 7.467530883796489, 1e-9);
  EXPECT_FALSE(estimate.over_sequences);
}

TEST(BatchStatistics, ClaimsNoIntervalOfOneValue) {
  const auto estimate = EstimateMean(OfOneSequence({3})).value();
  EXPECT_EQ(estimate.mean, 3);
  EXPECT_FALSE(estimate.low.has_value());
  EXPECT_FALSE(EstimateMean({}).has_value());
  EXPECT_FALSE(ComparePairs({}).has_value());
}

TEST(BatchStatistics, CountsAllSignsOfFewPairs) {
  const auto difference = ComparePairs(OfOneSequence(kEight)).value();
  // stats.permutation_test((d,), mean, permutation_type='samples', n_resamples=inf)
  EXPECT_DOUBLE_EQ(difference.p, 0.0390625);
  EXPECT_DOUBLE_EQ(difference.p_more, 0.01953125);
  EXPECT_NEAR(difference.p_less, 1 - 0.01953125 + 1.0 / 256, 1.0 / 256);
  EXPECT_DOUBLE_EQ(difference.p_least, 2.0 / 256);
  // (t.ppf(.975, 7) + t.ppf(.8, 7)) * sem(d)
  EXPECT_NEAR(difference.detectable.value(), 0.9466331056360915, 1e-9);
}

TEST(BatchStatistics, DrawsSignsOfManyPairs) {
  const std::vector<double> forty = {0.696,  1.172,  0.68,   -0.953, 1.255,  0.796,  -0.187, 0.931,
                                     0.715,  0.644,  0.378,  0.897,  -0.386, 0.187,  -0.132, 0.949,
                                     0.39,   0.058,  -0.432, 0.093,  0.358,  0.074,  1.644,  1.357,
                                     -2.361, -1.539, 0.175,  -0.072, 0.564,  0.567,  2.468,  -0.762,
                                     -0.028, 2.393,  0.997,  1.013,  -0.164, -1.298, 0.517,  0.459};
  const auto difference = ComparePairs(OfOneSequence(forty)).value();
  // SciPy with a million draws: 0.0226; four standard deviations of 100 000 draws.
  EXPECT_NEAR(difference.p, 0.0226, 0.002);
  EXPECT_DOUBLE_EQ(ComparePairs(OfOneSequence(forty))->p, difference.p) << "the same each time";
}

TEST(BatchStatistics, PairsThatAreEqualTellNothing) {
  std::vector<double> values = kEight;
  values.insert(values.end(), 30, 0.0);
  const auto difference = ComparePairs(OfOneSequence(values)).value();
  EXPECT_EQ(difference.differing, 8);
  EXPECT_DOUBLE_EQ(difference.p, 0.0390625);
  const auto same = ComparePairs(OfOneSequence({0, 0, 0})).value();
  EXPECT_EQ(same.p, 1);
  EXPECT_EQ(same.p_less, 1);
  EXPECT_EQ(same.detectable, 0);
}

TEST(BatchStatistics, SequencesWeighTheSameHoweverManySeedsTheyHave) {
  std::vector<SequenceValue> values = {{0, 1.0}};
  for (int i = 0; i < 9; ++i) values.push_back({1, -1.0});
  EXPECT_NEAR(ComparePairs(values)->mean.mean, 0, 1e-12);
}

/// Normal numbers about `mean` for `sequences` sequences that differ by `between`.
std::vector<SequenceValue> Drawn(std::uint32_t trial, int sequences, int seeds, double between,
                                 double mean) {
  Random random({.seed = 7, .frame = trial});
  std::vector<SequenceValue> values;
  for (int s = 0; s < sequences; ++s) {
    const double of_sequence = mean + between * random.Gaussian();
    for (int i = 0; i < seeds; ++i) values.push_back({s, of_sequence + random.Gaussian()});
  }
  return values;
}

TEST(BatchStatistics, IntervalsHoldTheTruthAsOftenAsTheySay) {
  int held = 0;
  constexpr int kTrials = 4000;
  for (std::uint32_t trial = 0; trial < kTrials; ++trial) {
    const auto estimate = EstimateMean(Drawn(trial, 6, 4, 1.0, 2.0)).value();
    held += *estimate.low <= 2 && 2 <= *estimate.high ? 1 : 0;
  }
  // Three standard deviations of a share of 0.95 in 4000.
  EXPECT_THAT(held / double{kTrials}, DoubleNear(0.95, 0.0104));
}

TEST(BatchStatistics, FindsTheDetectableDifferenceFourTimesOfFiveAndRaisesFewFalseAlarms) {
  int found = 0, false_alarms = 0;
  constexpr int kTrials = 1500;
  // Of 10 differences of deviation 1: (t.ppf(.975, 9) + t.ppf(.8, 9)) / sqrt(10)
  constexpr double kDetectable = 0.9947;
  for (std::uint32_t trial = 0; trial < kTrials; ++trial) {
    found += ComparePairs(Drawn(trial, 5, 2, 0.0, kDetectable))->p <= 0.05 ? 1 : 0;
    false_alarms += ComparePairs(Drawn(trial, 5, 2, 0.0, 0.0))->p <= 0.05 ? 1 : 0;
  }
  // The t approximation of a sign-flip test of 10 pairs, and three deviations of 1500 trials.
  EXPECT_THAT(found / double{kTrials}, DoubleNear(0.8, 0.05));
  EXPECT_LE(false_alarms / double{kTrials}, 0.05 + 0.017);
}

TEST(BatchStatistics, AdjustsAsHolmDoes) {
  const std::vector<double> p = {0.01, 0.04, 0.03, 0.005};
  EXPECT_THAT(HolmAdjusted(p), ElementsAre(DoubleNear(0.03, 1e-12), DoubleNear(0.06, 1e-12),
                                           DoubleNear(0.06, 1e-12), DoubleNear(0.02, 1e-12)));
  EXPECT_TRUE(HolmAdjusted({}).empty());
}

}  // namespace
}  // namespace plumbline
