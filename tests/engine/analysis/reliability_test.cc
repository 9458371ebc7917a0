// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/reliability.h"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "engine/base/random.h"

namespace plumbline {
namespace {

Eigen::Matrix4d SomeCovariance() {
  Eigen::Matrix4d root;
  root << 0.05, 0, 0, 0, 0.02, 0.03, 0, 0, 0, -0.01, 0.04, 0, 0.05, 0, 0.02, 0.1;
  return root * root.transpose();
}

TEST(CredibleLevel, IsUniformWhereTheBeliefIsHonest) {
  const Eigen::Matrix4d covariance = SomeCovariance();
  const Eigen::Matrix4d root = covariance.llt().matrixL();
  Random random({.seed = 5});
  constexpr int kDraws = 20'000;
  for (const bool round : {false, true}) {
    int half = 0, most = 0;
    for (int i = 0; i < kDraws; ++i) {
      const Eigen::Vector4d normal(random.Gaussian(), random.Gaussian(), random.Gaussian(),
                                   random.Gaussian());
      const double level = CredibleLevel(root * normal, covariance, round);
      EXPECT_GE(level, 0);
      EXPECT_LE(level, 1);
      half += level <= 0.5;
      most += level <= 0.95;
    }
    // Three binomial standard deviations, and the truth's own 3 mm.
    EXPECT_NEAR(half / double(kDraws), 0.5, 0.011 + 0.005) << round;
    EXPECT_NEAR(most / double(kDraws), 0.95, 0.005 + 0.003) << round;
  }
}

TEST(CredibleLevel, IsZeroAtTheMeanAndOneFarOff) {
  EXPECT_NEAR(CredibleLevel(Eigen::Vector4d::Zero(), SomeCovariance(), false), 0, 1e-12);
  EXPECT_NEAR(CredibleLevel({3, 0, 0, 0}, SomeCovariance(), false), 1, 1e-9);
  EXPECT_LT(CredibleLevel({0, 0, 0, 3}, SomeCovariance(), true), 1e-9) << "round: it may be turned";
  EXPECT_NEAR(CredibleLevel({0.001, 0, 0, 0}, Eigen::Matrix4d::Zero(), false), 0, 0.1)
      << "no belief is surer than the truth is known";
}

std::shared_ptr<const FrameSample> FrameOf(std::initializer_list<ObjectSample> objects) {
  auto frame = std::make_shared<FrameSample>();
  frame->objects = objects;
  return frame;
}

ObjectSample Sample(int id, float level, double claimed, bool right, float distance_m = 0.1f) {
  ObjectSample sample;
  sample.id = {id};
  sample.state = ObjectState::kConfirmed;
  sample.updated = true;
  sample.label_probability = {{{0}, claimed}};
  sample.error = TruthError{"t", right, distance_m, 0, level};
  return sample;
}

TEST(Reliability, CountsWhatWasClaimedAgainstWhatWasSo) {
  ObjectSample tentative = Sample(3, 0.1f, 0.9, true), hidden = tentative, unknown = tentative;
  tentative.state = ObjectState::kTentative;
  hidden.updated = false;
  unknown.error.reset();
  RunHistory history;
  history.frames = {nullptr, FrameOf({Sample(1, 0.3f, 0.95, true), Sample(2, 0.7f, 0.6, false)}),
                    FrameOf({Sample(1, 0.99f, 1.0, true), Sample(9, 0.1f, 1, true, 0.8f)}),
                    FrameOf({tentative, hidden, unknown})};
  const Reliability all = ReliabilityOf(history);
  EXPECT_EQ(all.poses, 3) << "neither what is far from any truth nor what is tentative or hidden";
  EXPECT_EQ(all.within_50, 1);
  EXPECT_EQ(all.within_95, 2);
  EXPECT_EQ(all.labels, 3);
  EXPECT_EQ(all.right, 2);
  EXPECT_NEAR(all.claimed, (0.95 + 0.6 + 1.0) / 3, 1e-12);
  EXPECT_EQ(all.bins[1].labels, 1);
  EXPECT_EQ(all.bins[3].labels, 1);
  EXPECT_EQ(all.bins[4].right, 1);
  EXPECT_EQ(ReliabilityOf(history, {2}).poses, 1);
  EXPECT_EQ(ReliabilityOf({}).claimed, 0);
}

}  // namespace
}  // namespace plumbline
