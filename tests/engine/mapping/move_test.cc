// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/move.h"

#include <gmock/gmock.h>

#include <cmath>

#include "engine/geometry/angles.h"
#include "tests/support/mapping_scene.h"

namespace plumbline {
namespace {

/// A chair seen from four sides.
class MoveTest : public testing::Test {
 protected:
  MoveTest() {
    const std::vector<Eigen::Vector3d> cameras = {
        {2.2, 0.6, 1.4}, {0.4, 2.3, 1.3}, {-1.9, 1.0, 1.5}, {0.3, -2.2, 1.2}};
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      inputs_.push_back(
          scene_.Input(static_cast<int>(i), LookAt(cameras[i], {0, 0, 0.4}), {&chair_, 1}));
    }
    for (const MapperInput& input : inputs_) {
      JudgingView judging;
      judging.view.camera = scene_.camera();
      judging.view.cam_from_world = input.world_from_cam.inverse();
      judging.view.table = input.table.get();
      judging.detections = input.detections.get();
      HypothesisScore score;
      const PoseHypothesis truth = scene_.Hypothesis(chair_);
      scene_.scorer()->Score(judging.view, scene_.map().upright, {&truth, 1}, {&score, 1});
      judging.normalizer = EdgeNormalizer({&score, 1});
      views_.push_back(judging);
    }
  }
  /// Particles around a wrong belief (2 cm, 3 degrees).
  MoveInput Believing(const Eigen::Vector3d& shift, double turn_deg, const char* label = "chair") {
    MoveInput input;
    input.wide = true;
    for (std::uint32_t i = 0; i < 500; ++i) {
      Random random({.seed = 5, .particle = i});
      PoseHypothesis hypothesis = scene_.Hypothesis(chair_);
      hypothesis.label = scene_.Label(label);
      hypothesis.center_in_world +=
          shift + Eigen::Vector3d(0.02 * random.Gaussian(), 0.02 * random.Gaussian(),
                                  0.01 * random.Gaussian());
      hypothesis.azimuth_rad =
          WrapAngle(hypothesis.azimuth_rad + (turn_deg + 3 * random.Gaussian()) * kRadPerDeg);
      input.particles.push_back(hypothesis);
    }
    return input;
  }
  std::vector<PoseHypothesis> Moved(const MoveInput& input, std::uint32_t frame = 1) {
    return ResampleMove(*scene_.scorer(), scene_.map(), views_, input, 500, options_,
                        {.seed = 9, .frame = frame});
  }
  /// Share within 4 cm, 6 degrees and of the right shape.
  double ShareAtTruth(const std::vector<PoseHypothesis>& hypotheses) {
    const PoseHypothesis truth = scene_.Hypothesis(chair_);
    double share = 0;
    for (const PoseHypothesis& hypothesis : hypotheses) {
      const bool near =
          hypothesis.label == truth.label &&
          (hypothesis.center_in_world - truth.center_in_world).norm() < 0.04 &&
          std::abs(WrapAngle(hypothesis.azimuth_rad - truth.azimuth_rad)) < 6 * kRadPerDeg;
      share += near / static_cast<double>(hypotheses.size());
    }
    return share;
  }

  MappingScene& scene_ = MappingScene::Get();
  const PlacedModel chair_ = scene_.Place("chair", 0.03, -0.04, 40);
  std::vector<MapperInput> inputs_;
  std::vector<JudgingView> views_;
  MapperOptions options_;
};

TEST_F(MoveTest, RecoversFromEightCentimetresAndTwentyDegrees) {
  for (const Eigen::Vector3d& shift : {Eigen::Vector3d(0.08, 0, 0), Eigen::Vector3d(0, -0.08, 0),
                                       Eigen::Vector3d(-0.06, 0.06, 0)}) {
    for (const double turn : {20.0, -20.0}) {
      // One move may be unlucky, two are not.
      MoveInput second;
      second.wide = true;
      second.particles = Moved(Believing(shift, turn), 1);
      EXPECT_GT(ShareAtTruth(Moved(second, 2)), 0.9) << shift.transpose() << ", " << turn;
    }
  }
}

TEST_F(MoveTest, RecoversFromAHalfTurn) {
  MoveInput second;
  second.wide = true;
  second.particles = Moved(Believing({0, 0, 0}, 180), 1);
  EXPECT_GT(ShareAtTruth(Moved(second, 2)), 0.9);
  // About the back rest: the body is 40 cm off.
  const Eigen::Vector3d to_back = chair_.world_from_object.linear() * Eigen::Vector3d(-0.4, 0, 0);
  second.particles = Moved(Believing(to_back, 180), 1);
  EXPECT_GT(ShareAtTruth(Moved(second, 2)), 0.9);
}

TEST_F(MoveTest, FindsTheRightShape) {
  EXPECT_GT(ShareAtTruth(Moved(Believing({0, 0, 0}, 0, "armchair"))), 0.9);
}

TEST_F(MoveTest, TakesNewcomersThatExplainMore) {
  MoveInput input = Believing({1.0, 0.5, 0}, 90);
  input.newcomers = Believing({0.05, 0.05, 0}, 8).particles;
  input.newcomers.resize(100);
  EXPECT_GT(ShareAtTruth(Moved(input)), 0.9);
}

TEST_F(MoveTest, StaysWhereTheTruthIsAlreadyKnown) {
  const std::vector<PoseHypothesis> moved = Moved(Believing({0, 0, 0}, 0));
  ASSERT_EQ(moved.size(), 500u);
  EXPECT_GT(ShareAtTruth(moved), 0.95);
  double squares = 0;
  for (const PoseHypothesis& hypothesis : moved)
    squares += std::pow(scene_.map().BaseHeight(hypothesis), 2);
  EXPECT_LT(std::sqrt(squares / 500), 2 * options_.floor_std_m);
}

TEST_F(MoveTest, RepeatsForTheSameKey) {
  const std::vector<PoseHypothesis> a = Moved(Believing({0.05, 0, 0}, 10)),
                                    b = Moved(Believing({0.05, 0, 0}, 10));
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].center_in_world, b[i].center_in_world);
    EXPECT_EQ(a[i].azimuth_rad, b[i].azimuth_rad);
  }
}

TEST_F(MoveTest, JudgesBySumOverViewsAndByTheFloor) {
  const PoseHypothesis truth = scene_.Hypothesis(chair_);
  PoseHypothesis floating = truth;
  floating.center_in_world.z() += 3 * options_.floor_std_m;
  const std::vector<PoseHypothesis> both = {truth, floating};
  double sum = 0;
  for (const JudgingView& view : views_) {
    sum += JudgeHypotheses(*scene_.scorer(), scene_.map(), {&view, 1}, both, options_)[0];
  }
  const auto judged = JudgeHypotheses(*scene_.scorer(), scene_.map(), views_, both, options_);
  EXPECT_NEAR(judged[0], sum, 1e-9);
  MapperOptions no_floor = options_;
  no_floor.floor_prior = false;
  const auto free = JudgeHypotheses(*scene_.scorer(), scene_.map(), views_, both, no_floor);
  EXPECT_NEAR(free[0], judged[0], 1e-9);
  EXPECT_NEAR(free[1] - judged[1], 4.5, 1e-6) << "three standard deviations";
}

}  // namespace
}  // namespace plumbline
