// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/own_poses.h"

#include <gmock/gmock.h>

#include "tests/support/simulated_sequence.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

SimulatedRecording Recording(double seconds = 6) {
  return Simulate({.seconds = seconds, .points = 80, .pixel_noise_px = 0});
}

TEST(OwnPoses, TellOfEachImageWhatIsKnownThen) {
  const auto sequence = SimulatedSequence(Recording());
  const auto poses = EstimateOwnPoses(sequence, sequence->num_frames(), {}, {});
  ASSERT_TRUE(poses.ok()) << poses.error().message;
  ASSERT_EQ(poses->frames.size(), 120u);
  const OwnPoseReport& first = poses->frames.front();
  EXPECT_FALSE(first.ready);
  EXPECT_THAT(first.waits_for, HasSubstr("waiting for"));
  EXPECT_FALSE(first.world_from_cam.has_value());
  const OwnPoseReport& last = poses->frames.back();
  ASSERT_TRUE(last.ready) << last.waits_for;
  EXPECT_TRUE(last.waits_for.empty());
  EXPECT_LT(last.tilt_std_rad, 0.02);
  EXPECT_GT(last.tracks.size(), 30u);
  EXPECT_GT(last.cam_covariance(0, 0), 0);
  // To the last bit: a run file keeps one half.
  for (const OwnPoseReport& frame : poses->frames) {
    EXPECT_EQ(frame.cam_covariance, frame.cam_covariance.transpose());
    EXPECT_EQ(frame.vio.covariance, frame.vio.covariance.transpose());
  }
  // Down in the camera is told right: three times what the simulator's start leaves.
  const Eigen::Matrix3d truth = sequence->world_from_cam(119)->linear();
  EXPECT_GT(last.world_from_cam->linear().row(2).dot(truth.row(2)), std::cos(0.03));

  const auto shorter = EstimateOwnPoses(sequence, 90, {}, {});
  ASSERT_TRUE(shorter.ok()) << shorter.error().message;
  ASSERT_EQ(shorter->frames.size(), 90u);
  for (std::size_t i = 0; i < 90; ++i) {
    const OwnPoseReport &a = poses->frames[i], &b = shorter->frames[i];
    EXPECT_EQ(a.ready, b.ready) << i;
    EXPECT_EQ(a.waits_for, b.waits_for) << i;
    EXPECT_EQ(a.floor.has_value(), b.floor.has_value()) << i;
    if (a.ready) {
      EXPECT_EQ(a.world_from_cam->matrix(), b.world_from_cam->matrix()) << i;
    }
  }
}

TEST(OwnPoses, ImagesThatComeTooSoonGetThePredictionOfTheImu) {
  const auto sequence = SimulatedSequence(Recording(4));
  OwnPoseOptions options;
  options.filter.max_rate_hz = 10;  // every second image
  const auto poses = EstimateOwnPoses(sequence, 80, options, {});
  ASSERT_TRUE(poses.ok()) << poses.error().message;
  int predicted = 0;
  for (std::size_t i = 1; i + 1 < poses->frames.size(); ++i) {
    const OwnPoseReport &before = poses->frames[i - 1], &frame = poses->frames[i];
    if (frame.measured || !frame.ready || !before.ready) continue;
    ++predicted;
    const Eigen::Isometry3d truth = sequence->world_from_cam(static_cast<int>(i) - 1)->inverse() *
                                    *sequence->world_from_cam(static_cast<int>(i));
    const Eigen::Isometry3d moved = before.world_from_cam->inverse() * *frame.world_from_cam;
    // 50 ms at a velocity that is known to 5 cm/s, with a margin.
    EXPECT_LT((moved.translation() - truth.translation()).norm(), 0.02) << i;
  }
  EXPECT_GT(predicted, 10);
}

TEST(OwnPoses, WhatASequenceLacksIsSaidInOneSentence) {
  SimulatedRecording without_imu = Recording(1), without_place = Recording(1);
  without_imu.samples.clear();
  without_place.camera.body_from_cam.reset();
  const auto message = [](SimulatedRecording recording) {
    const auto poses = EstimateOwnPoses(SimulatedSequence(std::move(recording)), 20, {}, {});
    EXPECT_FALSE(poses.ok());
    return poses.ok() ? std::string() : poses.error().message;
  };
  EXPECT_THAT(message(without_imu), HasSubstr("needs imu.csv"));
  EXPECT_THAT(message(without_place), HasSubstr("add 'body_from_cam' to camera.json"));
  EXPECT_THAT(message(Recording(0.5)), HasSubstr("got a pose that serves mapping: waiting for"));
}

TEST(OwnPoses, StopWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  WorkContext work;
  work.stop = stop.get_token();
  const auto poses = EstimateOwnPoses(SimulatedSequence(Recording(1)), 20, {}, work);
  ASSERT_FALSE(poses.ok());
  EXPECT_EQ(poses.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace plumbline
