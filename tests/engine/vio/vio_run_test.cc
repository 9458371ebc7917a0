// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/vio_run.h"

#include <gmock/gmock.h>

#include "engine/geometry/angles.h"
#include "tests/support/vio_simulator.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

VioRun RunOn(const SimulatedRecording& recording, bool given_start,
             const VioOptions& options = {}) {
  VioInput input;
  input.camera = recording.camera;
  input.imu = recording.imu;
  input.samples = recording.samples;
  if (given_start) input.start = recording.truth.front();
  return RunVio(input, recording.images, options, {});
}

const ReferenceState& TruthAt(const SimulatedRecording& recording, std::int64_t stamp_ns) {
  for (const ReferenceState& state : recording.truth) {
    if (state.stamp_ns == stamp_ns) return state;
  }
  ADD_FAILURE() << "no truth at " << stamp_ns;
  return recording.truth.front();
}

double Tilt(const SimulatedRecording& recording, const VioReport& report) {
  const Eigen::Vector3d a = report.world_from_body.linear().row(2).transpose();
  const Eigen::Vector3d b =
      TruthAt(recording, report.stamp_ns).world_from_body.linear().row(2).transpose();
  return std::acos(std::min(1.0, a.dot(b))) * kDegPerRad;
}

TEST(VioRun, KnowsHowWellItKnowsThePose) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SimulatedRecording recording = Simulate({.seconds = 12, .seed = seed});
    for (const VioReport& report : RunOn(recording, true).reports) {
      const Eigen::Isometry3d truth = TruthAt(recording, report.stamp_ns).world_from_body;
      const Eigen::AngleAxisd turn(
          Eigen::Matrix3d(truth.linear() * report.world_from_body.linear().transpose()));
      Eigen::Matrix<double, 6, 1> error;
      error << truth.translation() - report.world_from_body.translation(),
          turn.angle() * turn.axis();
      sum += error.dot(report.covariance.ldlt().solve(error));
      ++count;
    }
  }
  // 6 if honest. Five runs whose errors are correlated along each of them spread by about 1.5;
  // below 3 it would be timid, as it is somewhat by design: the noise of the IMU is raised by half.
  EXPECT_GT(sum / count, 2);
  EXPECT_LT(sum / count, 12);
}

TEST(VioRun, StartsFromRestAndFollows) {
  const SimulatedRecording recording = Simulate({.seconds = 12, .rest_s = 3, .seed = 2});
  const VioRun run = RunOn(recording, false);
  ASSERT_FALSE(run.reports.empty());
  EXPECT_EQ(run.reports.front().phase, VioPhase::kWaiting);
  EXPECT_THAT(run.reports.front().message, HasSubstr("waiting"));
  const VioReport& last = run.reports.back();
  ASSERT_EQ(last.phase, VioPhase::kTracking);
  EXPECT_EQ(last.stretch, 1);
  EXPECT_LT((last.gyro_bias - Eigen::Vector3d(0.01, -0.02, 0.015)).norm(), 0.002);
  EXPECT_LT(Tilt(recording, last), 0.5);
}

TEST(VioRun, StartsInMotion) {
  const SimulatedRecording recording = Simulate({.seconds = 10, .seed = 3});
  const VioRun run = RunOn(recording, false);
  const VioReport& last = run.reports.back();
  ASSERT_EQ(last.phase, VioPhase::kTracking);
  EXPECT_LT(Tilt(recording, last), 1);
  const double speed = TruthAt(recording, last.stamp_ns).velocity_in_world.norm();
  EXPECT_NEAR(last.velocity_in_world.norm(), speed, 0.08);  // 5 % of a speed of 1.5 m/s
}

TEST(VioRun, DoesNotRestWhereItsVelocityBeliesIt) {
  const SimulatedRecording recording = Simulate({.seconds = 6, .seed = 3});
  VioOptions options;
  options.zero_velocity_px = 1e6;  // whatever the points do looks like rest
  const VioReport& last = RunOn(recording, true, options).reports.back();
  ASSERT_EQ(last.phase, VioPhase::kTracking);
  EXPECT_EQ(last.stretch, 1);
  const ReferenceState& truth = TruthAt(recording, last.stamp_ns);
  ASSERT_GT(truth.velocity_in_world.norm(), 0.5);
  EXPECT_LT((last.velocity_in_world - truth.velocity_in_world).norm(), 0.1);
}

TEST(VioRun, FindsTheCalibrationThatItWasGivenWrongly) {
  SimulatedRecording recording = Simulate({.seconds = 40, .time_offset_s = 0.01, .seed = 4});
  const Eigen::Isometry3d truth = *recording.camera.body_from_cam;
  Eigen::Isometry3d wrong = truth;
  wrong.linear() =
      Eigen::AngleAxisd(0.0173, Eigen::Vector3d(1, 1, -1).normalized()) * truth.linear();
  wrong.translation() += Eigen::Vector3d(0.01, -0.01, 0.01);
  recording.camera.body_from_cam = wrong;  // and the offset is taken as zero
  const VioReport last = RunOn(recording, true).reports.back();
  const Eigen::AngleAxisd off(
      Eigen::Matrix3d(last.body_from_cam.linear() * truth.linear().transpose()));
  EXPECT_LT(off.angle() * kDegPerRad, 0.1);
  EXPECT_LT((last.body_from_cam.translation() - truth.translation()).norm(), 0.01);
  EXPECT_NEAR(last.time_offset_s, 0.01, 0.001);
}

TEST(VioRun, FindsIntrinsicsAndReadOutThatItWasGivenWrongly) {
  SimulatedRecording recording = Simulate({.seconds = 40, .rolling_shutter_s = 0.02, .seed = 4});
  const Camera truth = recording.camera;
  recording.camera.pinhole.fx *= 1.01;
  recording.camera.pinhole.fy *= 0.99;
  recording.camera.pinhole.cx += 3;
  recording.camera.pinhole.cy -= 3;
  recording.camera.distortion[0] += 0.01;
  recording.camera.rolling_shutter_s = 0;
  VioOptions options;
  options.estimate_intrinsics = options.estimate_rolling_shutter = true;
  const VioReport last = RunOn(recording, true, options).reports.back();
  EXPECT_NEAR(last.lens[0], truth.pinhole.fx, 0.5);
  EXPECT_NEAR(last.lens[1], truth.pinhole.fy, 0.5);
  EXPECT_NEAR(last.lens[2], truth.pinhole.cx, 0.5);
  EXPECT_NEAR(last.lens[3], truth.pinhole.cy, 0.5);
  EXPECT_NEAR(last.lens[4], truth.distortion[0], 0.002);
  EXPECT_NEAR(last.lens[kReadOut], 0.02, 0.0015);  // 3.4 of what it believes
  // It knows how well.
  EXPECT_LT(last.lens_spread[0], 0.5);
  EXPECT_LT(std::abs(last.lens[kReadOut] - 0.02), 4 * last.lens_spread[kReadOut]);
}

TEST(VioRun, FollowsTheRoomAndNotWhatSlidesThroughThePicture) {
  const SimulatedRecording recording = Simulate(
      {.seconds = 12, .sliding_share = 0.4, .sliding_from_s = 6, .sliding_px = 1.5, .seed = 6});
  const VioReport last = RunOn(recording, true).reports.back();
  const ReferenceState& truth = TruthAt(recording, last.stamp_ns);
  EXPECT_EQ(last.stretch, 1);
  EXPECT_LT((last.world_from_body.translation() - truth.world_from_body.translation()).norm(), 0.1);
}

/// Root mean square of the distances from where the body was, from images `from_s` on [m].
double PositionError(const SimulatedRecording& recording, const VioRun& run, double from_s) {
  double sum = 0;
  int count = 0;
  for (const VioReport& report : run.reports) {
    if (static_cast<double>(report.stamp_ns) < from_s * 1e9) continue;
    if (report.phase != VioPhase::kTracking) return 1e9;
    sum += (report.world_from_body.translation() -
            TruthAt(recording, report.stamp_ns).world_from_body.translation())
               .squaredNorm();
    ++count;
  }
  return std::sqrt(sum / std::max(1, count));
}

TEST(VioRun, UsesTheReadOutThatTheCameraStates) {
  SimulatedRecording recording =
      Simulate({.seconds = 12, .pixel_noise_px = 0.3, .rolling_shutter_s = 0.03, .seed = 11});
  const double told = PositionError(recording, RunOn(recording, true), 4);
  VioOptions wrong;
  wrong.rolling_shutter_s = -0.03;  // an option takes the camera's place
  const double turned = PositionError(recording, RunOn(recording, true, wrong), 4);
  recording.camera.rolling_shutter_s = 0;
  const double untold = PositionError(recording, RunOn(recording, true), 4);
  VioOptions given;
  given.rolling_shutter_s = 0.03;
  EXPECT_EQ(PositionError(recording, RunOn(recording, true, given), 4), told);
  EXPECT_LT(told, 0.02);
  EXPECT_GT(untold, 2 * told);
  EXPECT_GT(turned, 2 * told);
}

TEST(VioRun, StartsInMotionWithARollingShutter) {
  const SimulatedRecording recording =
      Simulate({.seconds = 8, .rolling_shutter_s = 0.03, .seed = 3});
  const VioRun run = RunOn(recording, false);
  const VioReport& last = run.reports.back();
  ASSERT_EQ(last.phase, VioPhase::kTracking);
  EXPECT_LT(Tilt(recording, last), 1);
  const double speed = TruthAt(recording, last.stamp_ns).velocity_in_world.norm();
  EXPECT_NEAR(last.velocity_in_world.norm(), speed, 0.08);  // 5 % of a speed of 1.5 m/s
}

TEST(VioRun, GivesTheSameTwice) {
  const SimulatedRecording recording = Simulate({.seconds = 4, .seed = 9});
  const VioReport a = RunOn(recording, true).reports.back(),
                  b = RunOn(recording, true).reports.back();
  EXPECT_EQ(a.world_from_body.matrix(), b.world_from_body.matrix());
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(VioRun, StartsAnewAndSaysWhyWhereTheReadingsRunAway) {
  SimulatedRecording recording = Simulate({.seconds = 12, .seed = 10});
  for (ImuSample& sample : recording.samples) {
    if (sample.stamp_ns > 4'000'000'000 && sample.stamp_ns < 4'600'000'000)
      sample.specific_force_m_s2.x() += 400;
  }
  const VioRun run = RunOn(recording, true);
  bool lost = false;
  for (const VioReport& report : run.reports)
    lost = lost || report.message.find("run away") != std::string::npos;
  EXPECT_TRUE(lost);
  EXPECT_GE(run.reports.back().stretch, 2);
}

}  // namespace
}  // namespace plumbline
