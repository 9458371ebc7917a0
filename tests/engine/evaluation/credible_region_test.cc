// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/credible_region.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "engine/base/random.h"
#include "engine/evaluation/honest_nees.h"
#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

Eigen::Vector4d Normal(Random& random) {
  return {random.Gaussian(), random.Gaussian(), random.Gaussian(), random.Gaussian()};
}

BeliefMode SomeMode() {
  Eigen::Matrix4d root;
  root << 0.05, 0, 0, 0, 0.02, 0.03, 0, 0, 0, -0.01, 0.04, 0, 0.05, 0, 0.02, 0.1;
  BeliefMode mode;
  mode.mean << 1, 2, 0.5, 3.1;  // its azimuth reaches over pi
  mode.covariance = root * root.transpose();
  return mode;
}

BeliefMode At(double x, double azimuth_deg, double weight, double std_m = 0.02) {
  BeliefMode mode;
  mode.weight = weight;
  mode.mean << x, 0, 0, azimuth_deg * kRadPerDeg;
  mode.covariance.diagonal() << std_m * std_m, std_m * std_m, std_m * std_m, 0.002;
  return mode;
}

/// How often a truth that is drawn (and then mistaken by the truth's own deviation) lies in the
/// regions of `claimed`.
struct Share {
  double in_50 = 0, in_95 = 0;
};
Share ShareOf(const std::function<Eigen::Vector4d(Random& random)>& draw,
              const std::vector<BeliefMode>& claimed, TrueState truth, int draws) {
  Random random({.seed = 7});
  Share share;
  for (int i = 0; i < draws; ++i) {
    truth.state = draw(random);
    Eigen::Vector4d mistake = truth.position_std_m / std::sqrt(3.0) * Normal(random);
    mistake[3] = truth.azimuth_std_rad * random.Gaussian();
    truth.state += mistake;
    const double level = CredibleLevel(claimed, truth);
    share.in_50 += level <= 0.5;
    share.in_95 += level <= 0.95;
  }
  share.in_50 /= draws;
  share.in_95 /= draws;
  return share;
}

/// The same, drawn from a mixture of Gaussians.
Share ShareOf(const std::vector<BeliefMode>& drawn_from, const std::vector<BeliefMode>& claimed,
              const TrueState& truth, int draws) {
  double weight = 0;
  for (const BeliefMode& mode : drawn_from) weight += mode.weight;
  const auto draw = [&](Random& random) {
    double left = weight * random.Uniform();
    std::size_t chosen = 0;
    while (chosen + 1 < drawn_from.size() && left >= drawn_from[chosen].weight)
      left -= drawn_from[chosen++].weight;
    const BeliefMode& mode = drawn_from[chosen];
    Eigen::Vector4d state = mode.mean + mode.covariance.llt().matrixL() * Normal(random);
    if (mode.symmetry_order == 0)
      state[3] = random.Uniform(0, 2 * std::numbers::pi);
    else
      state[3] += 2 * std::numbers::pi / mode.symmetry_order * random.Index(12);
    return state;
  };
  return ShareOf(draw, claimed, truth, draws);
}

/// Three binomial standard deviations, and 1 % for the 512 draws of a mixture.
void ExpectHonest(const Share& share, int draws) {
  EXPECT_NEAR(share.in_50, 0.5, 3 * std::sqrt(0.25 / draws) + 0.01);
  EXPECT_NEAR(share.in_95, 0.95, 3 * std::sqrt(0.0475 / draws) + 0.01);
}

TEST(CredibleLevel, IsHonestForOneGaussian) {
  for (const int order : {0, 1, 2}) {
    SCOPED_TRACE(order);
    BeliefMode mode = SomeMode();
    TrueState truth;
    mode.symmetry_order = truth.symmetry_order = order;
    ExpectHonest(ShareOf({mode}, {mode}, truth, 20'000), 20'000);
  }
}

TEST(CredibleLevel, IsHonestForMixturesThatOverlapOrDoNot) {
  const std::vector<BeliefMode> apart = {At(0, 0, 0.6), At(0, 180, 0.3, 0.05), At(0.5, 0, 0.1)};
  const std::vector<BeliefMode> overlapping = {At(0, 0, 0.5), At(0.03, 8, 0.5, 0.03)};
  ExpectHonest(ShareOf(apart, apart, {}, 3000), 3000);
  ExpectHonest(ShareOf(overlapping, overlapping, {}, 3000), 3000);
}

TEST(CredibleLevel, IsHonestForShapesOfDifferentSymmetry) {
  BeliefMode half = At(0, 10, 0.5), round = At(0.02, 0, 0.5);
  half.symmetry_order = 2;
  round.symmetry_order = 0;
  const std::vector<BeliefMode> belief = {half, round};
  ExpectHonest(ShareOf(belief, belief, {}, 3000), 3000);
}

TEST(CredibleLevel, IsHonestForAnAzimuthThatIsHardlyKnown) {
  BeliefMode wide = At(0, 30, 1);
  wide.covariance(3, 3) = 1.5;  // 70 degrees
  ExpectHonest(ShareOf({wide}, {wide}, {}, 3000), 3000);
}

TEST(CredibleLevel, AddsTheDeviationOfTheTruth) {
  TrueState truth;
  truth.position_std_m = 0.03;
  truth.azimuth_std_rad = 0.05;
  ExpectHonest(ShareOf({SomeMode()}, {SomeMode()}, truth, 20'000), 20'000);
  const std::vector<BeliefMode> belief = {At(0, 0, 0.7), At(0.1, 0, 0.3)};
  ExpectHonest(ShareOf(belief, belief, truth, 3000), 3000);
}

/// As BeliefMode's Student's t, drawn as its definition has it: normal over the root of a
/// chi-square variable.
Eigen::Vector4d DrawT(const BeliefMode& mode, Random& random) {
  const int dof = static_cast<int>(mode.degrees_of_freedom);
  double square = 0;
  for (int i = 0; i < dof; ++i) square += std::pow(random.Gaussian(), 2);
  const Eigen::Vector4d normal = mode.covariance.llt().matrixL() * Normal(random);
  return mode.mean + std::sqrt((dof - 2) / square) * normal;
}

Share ShareOfT(const BeliefMode& mode, const std::vector<BeliefMode>& claimed,
               const TrueState& truth, int draws) {
  return ShareOf([&](Random& random) { return DrawT(mode, random); }, claimed, truth, draws);
}

TEST(CredibleLevel, IsHonestForStudentsT) {
  for (const double dof : {3., 4., 8.}) {
    SCOPED_TRACE(dof);
    BeliefMode t = SomeMode();
    t.degrees_of_freedom = dof;
    ExpectHonest(ShareOfT(t, {t}, {}, 20'000), 20'000);
    TrueState truth;
    truth.position_std_m = 0.05;
    truth.azimuth_std_rad = 0.08;
    ExpectHonest(ShareOfT(t, {t}, truth, 1500), 1500);
    // Half as many as a Gaussian of the same covariance has in its middle, and more far off.
    const Share as_normal = ShareOfT(t, {SomeMode()}, {}, 20'000);
    EXPECT_GT(as_normal.in_50, dof == 8 ? 0.55 : 0.65);
    EXPECT_LT(as_normal.in_95, 0.95);
  }
}

/// Of 4 dimensions and degrees of freedom: the covariance is twice the scale, so 2 d^2 / 4 has the
/// F distribution of 4 and 4, which is y^2 (3 - 2 y) at y = 2 d^2 / (2 d^2 + 4).
TEST(CredibleLevel, OfStudentsTIsTheDistributionOfF) {
  BeliefMode t{.covariance = Eigen::Matrix4d::Identity() * 1e-4, .degrees_of_freedom = 4};
  for (const double squared : {0.1, 0.5, 2.0, 5.0, 12.8, 30.0}) {
    TrueState truth;
    truth.state[1] = 0.01 * std::sqrt(squared);
    const double y = 2 * squared / (4 + 2 * squared);
    EXPECT_NEAR(CredibleLevel(std::vector{t}, truth), y * y * (3 - 2 * y), 1e-4) << squared;
  }
}

TEST(CredibleLevel, OfSeveralStudentsTIsHonest) {
  std::vector<BeliefMode> twins = {At(0, 0, 0.5), At(0.3, 180, 0.5)};
  for (BeliefMode& mode : twins) mode.degrees_of_freedom = 4;
  // Either of two that are far apart: the truth is in its region as often as in that of one.
  ExpectHonest(ShareOfT(twins[1], twins, {}, 1000), 1000);
}

TEST(CredibleLevel, CatchesOverconfidenceAndItsOpposite) {
  BeliefMode narrow = SomeMode(), wide = SomeMode();
  narrow.covariance /= 4;
  wide.covariance *= 4;
  // chi-square of 4 degrees: P(d2 <= 3.357 / 4) = 0.067, P(d2 <= 9.488 / 4) = 0.332;
  // P(d2 <= 4 * 3.357) = 0.9907.
  const Share sure = ShareOf({SomeMode()}, {narrow}, {}, 20'000);
  EXPECT_NEAR(sure.in_50, 0.067, 0.006);
  EXPECT_NEAR(sure.in_95, 0.332, 0.011);
  EXPECT_NEAR(ShareOf({SomeMode()}, {wide}, {}, 20'000).in_50, 0.9907, 0.003);
  // Weights that are believed too surely: the modes claim 95 to 5, and are 50 to 50.
  const Share twins =
      ShareOf({At(0, 0, 0.5), At(0, 180, 0.5)}, {At(0, 0, 0.95), At(0, 180, 0.05)}, {}, 3000);
  // .95 exp(-a / 2) = .05 exp(-b / 2) at the border: .5 F(a), and .5 F(a) + .5 F(b).
  EXPECT_NEAR(twins.in_50, 0.263, 0.035);
  EXPECT_NEAR(twins.in_95, 0.811, 0.035);
}

TEST(CredibleLevel, IsZeroAtTheMeanAndOneFarOff) {
  TrueState truth;
  truth.state = SomeMode().mean;
  EXPECT_NEAR(CredibleLevel(std::vector{SomeMode()}, truth), 0, 1e-9);
  truth.state[0] += 3;
  EXPECT_NEAR(CredibleLevel(std::vector{SomeMode()}, truth), 1, 1e-9);
  EXPECT_NEAR(CredibleLevel(std::vector{At(0, 0, 1), At(1, 0, 1)}, truth), 1, 1e-9);
  const BeliefMode certain{.mean = Eigen::Vector4d::Zero()};
  EXPECT_EQ(CredibleLevel(std::vector{certain}, {}), 0) << "no spread is a density all the same";
}

TEST(Nees, OfHonestBeliefsLiesBetweenTheQuantilesOfF) {
  // Of one object: 2 y / (1 - y), y^2 (3 - 2 y) = p, so y = 1/2 - sin(asin(1 - 2 p) / 3).
  const auto quantile = [](double p) {
    const double y = 0.5 - std::sin(std::asin(1 - 2 * p) / 3);
    return 2 * y / (1 - y);
  };
  const NeesInterval one = HonestMeanNees(1, 4);
  EXPECT_NEAR(one.low / quantile(0.025), 1, 0.1);
  EXPECT_NEAR(one.high / quantile(0.975), 1, 0.1);
  // Of thirty: by 400 000 draws of scipy's F distribution.
  const NeesInterval thirty = HonestMeanNees(30, 4);
  EXPECT_NEAR(thirty.low, 2.152, 0.05);
  EXPECT_NEAR(thirty.high, 8.016, 0.5);
}

TEST(Nees, HasTheMeanOfItsDegreesOfFreedom) {
  for (const int order : {0, 1}) {
    BeliefMode mode = SomeMode();
    TrueState truth;
    mode.symmetry_order = truth.symmetry_order = order;
    Random random({.seed = 11});
    constexpr int kDraws = 20'000;
    double sum = 0;
    for (int i = 0; i < kDraws; ++i) {
      truth.state = mode.mean + mode.covariance.llt().matrixL() * Normal(random);
      truth.state[3] = std::remainder(truth.state[3], 2 * std::numbers::pi);
      const Nees nees = NeesOf(mode, truth);
      EXPECT_EQ(nees.degrees_of_freedom, order == 0 ? 3 : 4);
      sum += nees.value;
    }
    // Variance 2 n; three standard deviations of the mean.
    const double expected = order == 0 ? 3 : 4;
    EXPECT_NEAR(sum / kDraws, expected, 3 * std::sqrt(2 * expected / kDraws));
  }
}

}  // namespace
}  // namespace plumbline
