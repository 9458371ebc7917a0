// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/motion_test.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

namespace plumbline {
namespace {

struct Sight {
  double t_s;
  Eigen::Vector2d place_m;
  Eigen::Matrix2d covariance;
};

MotionTest TestOf(const std::vector<Sight>& sights) {
  MotionTest test;
  for (const Sight& sight : sights)
    test.Add(std::llround(sight.t_s * 1e9), {}, sight.place_m, sight.covariance.inverse());
  return test;
}

/// Boxes of something seen from a car that comes nearer, 10 a second; it errs by 10 % of the
/// distance along x and by 0.2 m across.
std::vector<Sight> Sights(const Eigen::Vector2d& velocity_m_s, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Sight> sights;
  for (int i = 0; i < count; ++i) {
    const double t_s = 0.1 * i;
    const Eigen::Vector2d place = Eigen::Vector2d(30, 4) + t_s * velocity_m_s;
    const double distance = std::max(3.0, place.x() - 10 * t_s);
    const Eigen::Vector2d deviations(0.1 * distance, 0.2);
    const double across = normal(random), along = normal(random);
    sights.push_back({t_s, place + deviations.cwiseProduct(Eigen::Vector2d(along, across)),
                      deviations.cwiseAbs2().asDiagonal()});
  }
  return sights;
}

TEST(MotionTest, IsTheRatioOfTheMarginalLikelihoods) {
  // The same by whole Gaussians: places of all boxes together, with a flat prior of the place as a
  // very wide one, which cancels in the ratio.
  const MapperOptions options;
  const std::vector<Sight> sights = Sights({3, -1}, 6, 4);
  const auto log_likelihood = [&](double speed_variance) {
    const auto n = static_cast<Eigen::Index>(2 * sights.size());
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd places(n);
    for (Eigen::Index i = 0; i < n / 2; ++i) {
      const Sight& a = sights[static_cast<std::size_t>(i)];
      places.segment<2>(2 * i) = a.place_m - sights.front().place_m;
      for (Eigen::Index j = 0; j < n / 2; ++j) {
        const Sight& b = sights[static_cast<std::size_t>(j)];
        covariance.block<2, 2>(2 * i, 2 * j) =
            (1e6 + speed_variance * a.t_s * b.t_s) * Eigen::Matrix2d::Identity();
      }
      covariance.block<2, 2>(2 * i, 2 * i) += a.covariance;
    }
    const Eigen::LDLT<Eigen::MatrixXd> solved(covariance);
    return -0.5 * places.dot(solved.solve(places)) - 0.5 * solved.vectorD().array().log().sum();
  };
  const double speed = options.moving_speed_m_s, feigned = options.feigned_speed_m_s;
  EXPECT_NEAR(TestOf(sights).LogBayesFactor(options),
              log_likelihood(speed * speed) - log_likelihood(feigned * feigned),
              1e-3);  // what the prior of a kilometre adds
}

TEST(MotionTest, TellsWhatStandsFromWhatDrives) {
  // Of what keeps 30 m ahead for two seconds, 20 boxes with 3 m each tell the speed within
  // 3 / (sqrt(20) 0.58) = 1.2 m/s: 10 m/s are 8.7 deviations. Across the road 12 boxes tell it
  // within 0.2 m/s; but 3 m/s are only two deviations of what errors of boxes may feign.
  const MapperOptions options;
  for (unsigned seed = 0; seed < 20; ++seed) {
    EXPECT_GT(TestOf(Sights({0, 0}, 20, seed)).LogStanding(options), std::log(0.9)) << seed;
    EXPECT_LT(TestOf(Sights({10, 0}, 20, seed)).LogStanding(options), std::log(0.05)) << seed;
    EXPECT_LT(TestOf(Sights({-10, 0}, 20, seed)).LogStanding(options), std::log(0.05)) << seed;
    EXPECT_LT(TestOf(Sights({0, 6}, 12, seed)).LogStanding(options), std::log(0.05)) << seed;
    EXPECT_LT(TestOf(Sights({0, 3}, 12, seed)).LogStanding(options),
              TestOf(Sights({0, 1}, 12, seed)).LogStanding(options))
        << seed;
  }
  // 30 boxes: 3 / (sqrt(30) 0.87) = 0.63 m/s; three deviations.
  EXPECT_NEAR(TestOf(Sights({9, 1}, 30, 1)).Velocity(options).x(), 9, 1.9);
}

TEST(MotionTest, ErrorsThatChangeSlowlyAreNoMotion) {
  // A bias of the distance that goes from 4 m to none within three seconds feigns 1.4 m/s, one of
  // the side that goes from 1.5 m 0.5 m/s; a walker is slower than that, a car is not.
  const MapperOptions options;
  MapperOptions without = options;
  without.feigned_speed_m_s = 0.01;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const MotionTest test = TestOf(Sights({-1.5, 0.5}, 30, seed));
    EXPECT_GT(test.LogStanding(options), std::log(0.9)) << seed;
    EXPECT_LT(test.LogStanding(without), test.LogStanding(options)) << seed;
  }
}

TEST(MotionTest, OfFewBoxesBelievesThePrior) {
  const MapperOptions options;
  EXPECT_NEAR(MotionTest().LogStanding(options), std::log(1 - options.moving_share), 1e-12);
  EXPECT_NEAR(TestOf(Sights({10, 0}, 1, 1)).LogStanding(options),
              std::log(1 - options.moving_share), 1e-12);
  MapperOptions nothing_moves;
  nothing_moves.moving_share = 0;
  EXPECT_EQ(TestOf(Sights({10, 0}, 20, 1)).LogStanding(nothing_moves), 0);
}

TEST(MotionTest, SurvivesARunFile) {
  const MapperOptions options;
  const MotionTest test = TestOf(Sights({5, 1}, 9, 2));
  ByteWriter out;
  test.Save(out);
  const std::string bytes = out.Take();
  MotionTest restored;
  ByteReader in(bytes);
  restored.Restore(in);
  EXPECT_TRUE(in.ok());
  EXPECT_EQ(restored.boxes(), 9);
  EXPECT_EQ(restored.LogBayesFactor(options), test.LogBayesFactor(options));
}

}  // namespace
}  // namespace plumbline
