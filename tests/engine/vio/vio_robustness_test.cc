// SPDX-License-Identifier: Apache-2.0
// What goes wrong in recordings: each is survived, with a bounded error, and said.
#include <algorithm>

#include <gmock/gmock.h>

#include "engine/geometry/angles.h"
#include "engine/vio/clock_search.h"
#include "engine/vio/vio_run.h"
#include "tests/support/vio_simulator.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kSecond = 1'000'000'000;

VioRun Estimate(const SimulatedRecording& recording, bool given_start = true) {
  VioInput input;
  input.camera = recording.camera;
  input.imu = recording.imu;
  input.samples = recording.samples;
  if (given_start) input.start = recording.truth.front();
  return RunVio(input, recording.images, VioOptions(), {});
}

/// All that was said, and where the run ended.
std::string Said(const VioRun& run) {
  std::string said;
  for (const VioReport& report : run.reports) said += report.message + "\n";
  return said;
}

/// The truth of the end; of a recording whose images were changed, its own number of them.
double EndError(const SimulatedRecording& recording, const VioRun& run) {
  return (run.reports.back().world_from_body.translation() -
          recording.truth.back().world_from_body.translation())
      .norm();
}

double EndTiltDeg(const SimulatedRecording& recording, const VioRun& run) {
  const Eigen::Vector3d down = run.reports.back().world_from_body.linear().row(2).transpose();
  const Eigen::Vector3d truth = recording.truth.back().world_from_body.linear().row(2).transpose();
  return std::acos(std::min(1.0, down.dot(truth))) * kDegPerRad;
}

/// Each axis' error of the end as a multiple of its standard deviation.
double EndErrorInSigmas(const SimulatedRecording& recording, const VioRun& run) {
  const VioReport& end = run.reports.back();
  const Eigen::Vector3d error =
      end.world_from_body.translation() - recording.truth.back().world_from_body.translation();
  return (error.array() / end.covariance.diagonal().head<3>().array().sqrt()).abs().maxCoeff();
}

void ShiftImages(SimulatedRecording& recording, std::int64_t from_ns, std::int64_t by_ns) {
  for (TrackedImage& image : recording.images)
    image.stamp_ns += image.stamp_ns > from_ns ? by_ns : 0;
}

void ShiftReadings(SimulatedRecording& recording, std::int64_t from_ns, std::int64_t by_ns) {
  for (ImuSample& s : recording.samples) s.stamp_ns += s.stamp_ns > from_ns ? by_ns : 0;
}

TEST(VioRobustness, DroppedAndDoubledImages) {
  SimulatedRecording recording = Simulate({.seconds = 10, .seed = 5});
  std::vector<TrackedImage> images;
  for (std::size_t k = 0; k < recording.images.size(); ++k) {
    if (k > 60 && k < 72) continue;
    images.push_back(recording.images[k]);
    if (k % 10 == 0) images.push_back(recording.images[k]);
  }
  recording.images = images;
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("no image came for 0.60 s"));
  EXPECT_THAT(Said(run), HasSubstr("1 of the images came twice or late"));
  EXPECT_EQ(run.reports.back().stretch, 1);
  EXPECT_LT(EndError(recording, run), 0.3);
}

TEST(VioRobustness, EveryOtherImageIsMissing) {
  SimulatedRecording recording = Simulate({.seconds = 10, .seed = 15});
  std::size_t k = 0;
  std::erase_if(recording.images, [&](const TrackedImage&) { return k++ % 2 == 0; });
  const VioRun run = Estimate(recording);
  EXPECT_EQ(run.reports.back().stretch, 1);
  EXPECT_LT(EndError(recording, run), 0.3);
}

TEST(VioRobustness, AGapOfTheImu) {
  SimulatedRecording recording = Simulate({.seconds = 10, .seed = 6});
  std::erase_if(recording.samples, [](const ImuSample& sample) {
    return sample.stamp_ns > 4 * kSecond && sample.stamp_ns < 4.3 * kSecond;
  });
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("the IMU gave no readings for 0.0"));
  EXPECT_EQ(run.reports.back().stretch, 1);
  EXPECT_LT(EndError(recording, run), 0.5);
}

TEST(VioRobustness, AnImuThatStopsForSeconds) {
  SimulatedRecording recording = Simulate({.seconds = 16, .seed = 16});
  std::erase_if(recording.samples, [](const ImuSample& sample) {
    return sample.stamp_ns > 4 * kSecond && sample.stamp_ns < 7 * kSecond;
  });
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("the IMU gave no readings for"));
  EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking);
  EXPECT_LT(EndErrorInSigmas(recording, run), 4);
  EXPECT_LT(EndTiltDeg(recording, run), 1.5);
}

TEST(VioRobustness, SaturatedReadings) {
  // A knock: half of the time for a tenth of a second beyond what the IMU can tell.
  SimulatedRecording recording = Simulate({.seconds = 10, .seed = 17});
  recording.imu.saturation_gyro_rad_s = 4;
  recording.imu.saturation_accel_m_s2 = 40;
  for (ImuSample& sample : recording.samples) {
    const double t = static_cast<double>(sample.stamp_ns) * 1e-9 - 4;
    if (t < 0 || t > 0.1) continue;
    const double knock = std::sin(2 * 3.141592653589793 * 40 * t);
    sample.specific_force_m_s2.x() =
        std::clamp(sample.specific_force_m_s2.x() + 120 * knock, -40.0, 40.0);
    sample.angular_velocity_rad_s.y() =
        std::clamp(sample.angular_velocity_rad_s.y() + 10 * knock, -4.0, 4.0);
  }
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("the IMU was saturated for"));
  EXPECT_EQ(run.reports.back().stretch, 1);
  EXPECT_LT(EndError(recording, run), 0.4);
}

TEST(VioRobustness, BothClocksAreSetBack) {
  SimulatedRecording recording = Simulate({.seconds = 16, .seed = 18});
  ShiftImages(recording, 6 * kSecond, -5 * kSecond);
  ShiftReadings(recording, 6 * kSecond, -5 * kSecond);
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("the IMU's clock was set back by 5.00 s"));
  EXPECT_THAT(Said(run), HasSubstr("the camera's clock was set back by 5.00 s"));
  EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking);
  EXPECT_EQ(run.reports.back().stretch, 2);
  EXPECT_NEAR(run.reports.back().time_offset_s, 0, 0.003);
  EXPECT_LT(EndErrorInSigmas(recording, run), 4);
}

TEST(VioRobustness, TheCamerasClockIsSetBack) {
  SimulatedRecording recording = Simulate({.seconds = 16, .seed = 19});
  ShiftImages(recording, 6 * kSecond, -2 * kSecond);
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("the camera's clock was set back by 2.00 s"));
  EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking);
  EXPECT_NEAR(run.reports.back().time_offset_s, 2, 0.003);
  EXPECT_LT(EndErrorInSigmas(recording, run), 4);
}

TEST(VioRobustness, TheImusClockIsSetBack) {
  SimulatedRecording recording = Simulate({.seconds = 16, .seed = 20});
  ShiftReadings(recording, 6 * kSecond, -2 * kSecond);
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("the IMU's clock was set back by 2.00 s"));
  EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking);
  EXPECT_NEAR(run.reports.back().time_offset_s, -2, 0.003);
  EXPECT_LT(EndErrorInSigmas(recording, run), 4);
}

TEST(VioRobustness, BothClocksAreSetForward) {
  SimulatedRecording recording = Simulate({.seconds = 16, .seed = 21});
  ShiftImages(recording, 6 * kSecond, 5 * kSecond);
  ShiftReadings(recording, 6 * kSecond, 5 * kSecond);
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("or a clock was set forward"));
  EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking);
  EXPECT_EQ(run.reports.back().stretch, 2);
  EXPECT_LT(EndErrorInSigmas(recording, run), 4);
}

TEST(VioRobustness, TheCamerasClockIsSetForward) {
  SimulatedRecording recording = Simulate({.seconds = 20, .seed = 22});
  ShiftImages(recording, 6 * kSecond, kSecond / 5);
  const VioRun run = Estimate(recording);

  EXPECT_THAT(Said(run), HasSubstr("disagreed with the state"));
  EXPECT_THAT(Said(run), HasSubstr("a clock has jumped"));
  EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking);
  EXPECT_NEAR(run.reports.back().time_offset_s, -0.2, 0.015);
  EXPECT_LT(EndErrorInSigmas(recording, run), 4);
}

TEST(VioRobustness, ACoveredLens) {
  SimulatedRecording recording = Simulate({.seconds = 12, .seed = 7});
  for (TrackedImage& image : recording.images) {
    if (image.stamp_ns > 4 * kSecond && image.stamp_ns < 6.5 * kSecond) image.points.clear();
    for (TrackedPoint& point : image.points)
      point.id += image.stamp_ns >= 6.5 * kSecond ? 1'000'000 : 0;
  }
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("no point could be used for 2."));
  EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking);
  EXPECT_EQ(run.reports.back().stretch, 1);
  EXPECT_LT(EndError(recording, run), 0.5);
}

TEST(VioRobustness, ALensThatIsCoveredForLongAndInMotion) {
  SimulatedRecording recording = Simulate({.seconds = 40, .seed = 23});
  for (TrackedImage& image : recording.images) {
    if (image.stamp_ns > 4 * kSecond && image.stamp_ns < 34 * kSecond) image.points.clear();
    for (TrackedPoint& point : image.points)
      point.id += image.stamp_ns >= 34 * kSecond ? 1'000'000 : 0;
  }
  const VioRun run = Estimate(recording);

  EXPECT_THAT(Said(run), HasSubstr("the IMU alone is too uncertain"));
  EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking);
  EXPECT_LT(EndErrorInSigmas(recording, run), 4);
  EXPECT_LT(EndTiltDeg(recording, run), 1.5);
}

TEST(VioRobustness, AStillCameraForAMinute) {
  const SimulatedRecording recording = Simulate({.seconds = 72, .rest_s = 62, .seed = 24});
  const VioRun run = Estimate(recording, false);
  const VioReport* before = nullptr;
  for (const VioReport& report : run.reports) {
    if (report.phase == VioPhase::kTracking && report.stamp_ns < 61.5 * kSecond) before = &report;
  }
  ASSERT_NE(before, nullptr);

  EXPECT_TRUE(before->resting);
  EXPECT_LT(before->world_from_body.translation().norm(), 0.01);
  EXPECT_LT(std::abs(Eigen::AngleAxisd(before->world_from_body.linear()).angle()), 0.2);
  EXPECT_LT(before->velocity_in_world.norm(), 0.01);
  EXPECT_LT((before->gyro_bias - Eigen::Vector3d(0.01, -0.02, 0.015)).norm(), 0.002);
  // Then it walks: what rest has taught must not have made the filter too sure.
  EXPECT_EQ(run.reports.back().stretch, 1);
  EXPECT_LT(EndTiltDeg(recording, run), 0.5);
  const double moved =
      (run.reports.back().world_from_body.translation() - before->world_from_body.translation())
          .norm();
  const double truly = (recording.truth.back().world_from_body.translation() -
                        recording.truth.front().world_from_body.translation())
                           .norm();
  EXPECT_NEAR(moved, truly, 0.1);
}

TEST(VioRobustness, PureRotation) {
  // The camera hangs on an arm, whose swing is all the parallax there is. Where it gives points a
  // depth it holds the body within centimetres; where it does not there is hardly more than the IMU
  // alone, which is 1 to 2 m off after ten seconds, and the filter says so.
  std::vector<double> errors;
  for (std::uint64_t seed = 8; seed < 13; ++seed) {
    const SimulatedRecording recording = Simulate({.seconds = 10, .moves = false, .seed = seed});
    const VioRun run = Estimate(recording);
    EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking) << seed;
    EXPECT_EQ(run.reports.back().stretch, 1) << seed;
    EXPECT_LT(EndErrorInSigmas(recording, run), 4) << seed;
    EXPECT_LT(EndTiltDeg(recording, run), 0.5) << seed;
    errors.push_back(EndError(recording, run));
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[2], 1);
  EXPECT_LT(errors.back(), 2.5);
}

TEST(VioRobustness, RotationAboutTheCameraItself) {
  const SimulatedRecording recording =
      Simulate({.seconds = 10, .moves = false, .arm = 0, .seed = 25});
  const VioRun run = Estimate(recording);
  EXPECT_THAT(Said(run), HasSubstr("no point shows parallax"));
  EXPECT_EQ(run.reports.back().phase, VioPhase::kTracking);
  EXPECT_EQ(run.reports.back().stretch, 1);
  EXPECT_LT(EndError(recording, run), 0.5);
  EXPECT_LT(EndErrorInSigmas(recording, run), 4);
  EXPECT_LT(EndTiltDeg(recording, run), 1);
}

TEST(ClockSearch, FindsAnOffsetFromTurnsAlone) {
  const SimulatedRecording recording =
      Simulate({.seconds = 10, .time_offset_s = 0.12, .gyro_bias = {0, 0, 0}, .seed = 26});
  ImuBuffer readings(recording.imu);
  for (const ImuSample& sample : recording.samples) readings.Add(sample);
  const std::span<const TrackedImage> images(recording.images.data() + 10, 180);
  const auto fit = SearchClock(recording.camera, readings, {0, 0, 0}, images, 0, 0.5);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->offset_s, 0.12, 0.015);  // a pixel is 2.5 mrad, at turns of .3 rad/s
  EXPECT_LT(fit->residual_px, 0.9 * fit->given_residual_px);
  EXPECT_FALSE(SearchClock(recording.camera, ImuBuffer(recording.imu), {0, 0, 0}, images, 0, 0.5));
}

}  // namespace
}  // namespace plumbline
