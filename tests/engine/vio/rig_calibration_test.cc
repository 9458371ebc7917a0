// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/rig_calibration.h"

#include <gtest/gtest.h>

#include "engine/geometry/angles.h"
#include "engine/vio/lens.h"
#include "engine/vio/rotation.h"
#include "tests/support/vio_simulator.h"

namespace plumbline {
namespace {

VioInput InputOf(const SimulatedRecording& recording) {
  VioInput input;
  input.camera = recording.camera;
  input.imu = recording.imu;
  input.samples = recording.samples;
  return input;
}

VioOptions WideOptions() {
  VioOptions options;
  options.extrinsic_rotation_std_deg = 1;
  options.extrinsic_translation_std_m = 0.02;
  options.time_offset_std_s = 0.01;
  return options;
}

TEST(CalibrateRig, AWrongCalibrationComesRight) {
  const SimulatedRecording recording =
      Simulate({.seconds = 20, .rest_s = 2, .time_offset_s = 0.004, .seed = 3});
  VioInput input = InputOf(recording);
  const Eigen::Isometry3d truth = *recording.camera.body_from_cam;
  input.camera.body_from_cam->linear() =
      RotationExp({0.006, -0.006, 0.005}) * truth.linear();  // 0.57 deg
  input.camera.body_from_cam->translation() += Eigen::Vector3d(0.006, -0.005, 0.006);
  input.imu.time_offset_s = 0.004 - 0.006;
  const Result<RigCalibration> found =
      CalibrateRig(input, recording.images, WideOptions(), 8, WorkContext());
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_TRUE(found->agreed);
  EXPECT_GE(found->passes.size(), 2u);
  RigEstimate true_rig;
  true_rig.body_from_cam = truth;
  true_rig.time_offset_s = 0.004;
  const RigVector off = Difference(true_rig, found->result);
  EXPECT_LT(off.head<3>().norm() * kDegPerRad, 0.1);
  EXPECT_LT(off.segment<3>(3).norm(), 0.01);
  EXPECT_LT(std::abs(off[6]), 0.001);
}

TEST(CalibrateRig, FindsLensAndReadOutWhereAskedTo) {
  const SimulatedRecording recording =
      Simulate({.seconds = 30, .rest_s = 2, .rolling_shutter_s = 0.02, .seed = 3});
  VioInput input = InputOf(recording);
  input.camera.pinhole.fx *= 1.01;
  input.camera.pinhole.cy -= 3;
  input.camera.distortion[0] += 0.01;
  input.camera.rolling_shutter_s = 0.01;
  VioOptions options = WideOptions();
  options.estimate_intrinsics = options.estimate_rolling_shutter = true;
  const Result<RigCalibration> found =
      CalibrateRig(input, recording.images, options, 8, WorkContext());
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_TRUE(found->agreed);
  const LensVector truth = LensOf(recording.camera), lens = found->result.lens;
  EXPECT_LT((lens - truth).head<4>().cwiseAbs().maxCoeff(), 0.5);  // [px]
  EXPECT_NEAR(lens[4], truth[4], 0.002);
  EXPECT_NEAR(lens[kReadOut], 0.02, 0.001);
  // A backward pass has the read-out with the other sign, and is told with the camera's own.
  EXPECT_NEAR(found->passes[1].estimates.back().lens[kReadOut], 0.02, 0.002);
  const Camera camera = WithLens(input.camera, lens);
  EXPECT_EQ(LensOf(camera), lens);
  EXPECT_EQ(camera.distortion.size(), input.camera.distortion.size());
}

TEST(Reverse, TwiceIsTheRecordingItself) {
  const SimulatedRecording recording = Simulate({.seconds = 2, .seed = 5});
  VioInput input = InputOf(recording);
  input.camera.rolling_shutter_s = 0.02;
  const ReversedRecording once = Reverse(input, recording.images);
  const ReversedRecording twice = Reverse(once.input, once.images);
  EXPECT_EQ(once.input.camera.rolling_shutter_s, -0.02);  // the last row is read first
  EXPECT_EQ(twice.input.camera.rolling_shutter_s, 0.02);
  ASSERT_EQ(twice.samples.size(), recording.samples.size());
  for (std::size_t i = 0; i < twice.samples.size(); ++i) {
    EXPECT_EQ(twice.samples[i].stamp_ns, recording.samples[i].stamp_ns);
    EXPECT_EQ(twice.samples[i].angular_velocity_rad_s, recording.samples[i].angular_velocity_rad_s);
    if (i > 0) {
      EXPECT_GT(once.samples[i].stamp_ns, once.samples[i - 1].stamp_ns);
    }
  }
  EXPECT_EQ(once.images.front().points.size(), recording.images.back().points.size());
  EXPECT_EQ(twice.images.back().stamp_ns, recording.images.back().stamp_ns);
}

TEST(Reverse, TheFilterFollowsItAsWell) {
  const SimulatedRecording recording = Simulate({.seconds = 12, .seed = 4});
  ReversedRecording reversed = Reverse(InputOf(recording), recording.images);
  ReferenceState start = recording.truth.back();
  start.stamp_ns = reversed.images.front().stamp_ns;
  start.velocity_in_world = -start.velocity_in_world;
  start.gyro_bias = -start.gyro_bias;
  reversed.input.start = start;
  const VioRun run = RunVio(reversed.input, reversed.images, {}, {});
  ASSERT_FALSE(run.reports.empty());
  const Eigen::Vector3d end = recording.truth.front().world_from_body.translation();
  EXPECT_LT((run.reports.back().world_from_body.translation() - end).norm(), 0.1);
}

TEST(Reverse, TheFilterFollowsARollingShutterAsWell) {
  const SimulatedRecording recording =
      Simulate({.seconds = 12, .pixel_noise_px = 0.3, .rolling_shutter_s = 0.03, .seed = 4});
  ReversedRecording reversed = Reverse(InputOf(recording), recording.images);
  ReferenceState start = recording.truth.back();
  start.stamp_ns = reversed.images.front().stamp_ns;
  start.velocity_in_world = -start.velocity_in_world;
  start.gyro_bias = -start.gyro_bias;
  reversed.input.start = start;
  const auto off = [&] {
    const VioRun run = RunVio(reversed.input, reversed.images, {}, {});
    const Eigen::Vector3d end = recording.truth.front().world_from_body.translation();
    return (run.reports.back().world_from_body.translation() - end).norm();
  };
  EXPECT_LT(off(), 0.04);
  reversed.input.camera.rolling_shutter_s *= -1;
  EXPECT_GT(off(), 0.08);
}

TEST(ImuNoise, IsFoundInAWalk) {
  const SimulatedRecording recording = Simulate({.seconds = 10, .rest_s = 3, .seed = 6});
  const ImuNoise noise = MeasureStillestNoise(recording.samples);
  EXPECT_NEAR(noise.gyro_density, recording.imu.gyro_noise_density,
              0.15 * recording.imu.gyro_noise_density);
  EXPECT_NEAR(noise.accel_density, recording.imu.accel_noise_density,
              0.15 * recording.imu.accel_noise_density);
  EXPECT_EQ(MeasureStillestNoise({}).gyro_density, 0);
}

TEST(ImuNoise, TheMeterFollowsAVibration) {
  SimulatedRecording recording = Simulate({.seconds = 6, .seed = 6});
  VibrationMeter meter(recording.imu.rate_hz);
  EXPECT_EQ(meter.noise().accel_density, 0);
  double quiet = 0;
  for (std::size_t i = 0; i < recording.samples.size(); ++i) {
    ImuSample sample = recording.samples[i];
    const bool shaken = i >= recording.samples.size() / 2;
    // Rotors: 5 m/s^2 at 80 Hz.
    if (shaken)
      sample.specific_force_m_s2.z() +=
          5 * std::sin(2 * 3.14159 * 80 * 0.005 * static_cast<double>(i));
    if (i == recording.samples.size() / 2) quiet = meter.noise().accel_density;
    meter.Add(sample);
  }
  EXPECT_NEAR(quiet, recording.imu.accel_noise_density, 0.2 * recording.imu.accel_noise_density);
  EXPECT_GT(meter.noise().accel_density, 20 * quiet);
  EXPECT_NEAR(meter.noise().gyro_density, recording.imu.gyro_noise_density,
              0.3 * recording.imu.gyro_noise_density);
}

TEST(CalibrateRig, SaysWhyThereIsNothing) {
  const SimulatedRecording recording = Simulate({.seconds = 1, .seed = 7});
  const VioInput input = InputOf(recording);
  const std::span<const TrackedImage> three(recording.images.data(), 3);
  const Result<RigCalibration> found = CalibrateRig(input, three, WideOptions(), 4, WorkContext());
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace plumbline
