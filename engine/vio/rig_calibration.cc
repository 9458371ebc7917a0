// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/rig_calibration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/vio/lens.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

constexpr double kAgree = 3;  ///< Standard deviations.

/// The state at the end of a pass, for the next to begin with in the opposite direction.
ReferenceState Turned(const VioReport& last, std::int64_t stamp_ns) {
  ReferenceState state;
  state.stamp_ns = stamp_ns;
  state.world_from_body = last.world_from_body;
  state.velocity_in_world = -last.velocity_in_world;
  state.gyro_bias = -last.gyro_bias;
  state.accel_bias = last.accel_bias;
  return state;
}

RigPass PassOf(const VioRun& run, bool backward, std::int64_t first_ns) {
  RigPass pass;
  pass.backward = backward;
  double nis = 0, dof = 0;
  for (const VioReport& report : run.reports) {
    if (report.phase != VioPhase::kTracking) continue;
    RigEstimate estimate;
    estimate.seconds = std::abs(static_cast<double>(report.stamp_ns - first_ns)) * 1e-9;
    estimate.body_from_cam = report.body_from_cam;
    estimate.time_offset_s = backward ? -report.time_offset_s : report.time_offset_s;
    estimate.lens = report.lens;
    if (backward) estimate.lens[kReadOut] *= -1;
    estimate.spread << report.spread.tail<7>(), report.lens_spread;
    pass.estimates.push_back(estimate);
    nis += report.step.nis;
    dof += report.step.nis_dof;
  }
  if (dof > 0) pass.nis_per_dof = nis / dof;
  return pass;
}

RigEstimate MeanOf(const RigEstimate& a, const RigEstimate& b) {
  RigEstimate mean = a;
  const RigVector difference = Difference(a, b);
  mean.body_from_cam.linear() = RotationExp(0.5 * difference.head<3>()) * a.body_from_cam.linear();
  mean.body_from_cam.translation() += 0.5 * difference.segment<3>(3);
  mean.time_offset_s += 0.5 * difference[6];
  mean.lens += 0.5 * difference.tail<kLensSize>();
  mean.spread = a.spread.cwiseMax(b.spread).cwiseMax(0.5 * difference.cwiseAbs());
  return mean;
}

bool Agree(const RigEstimate& a, const RigEstimate& b) {
  return (Difference(a, b).cwiseAbs().array() <= kAgree * a.spread.cwiseMax(b.spread).array())
      .all();
}

}  // namespace

RigVector Difference(const RigEstimate& a, const RigEstimate& b) {
  RigVector difference;
  difference << RotationLog(b.body_from_cam.linear() * a.body_from_cam.linear().transpose()),
      b.body_from_cam.translation() - a.body_from_cam.translation(),
      b.time_offset_s - a.time_offset_s, b.lens - a.lens;
  return difference;
}

ReversedRecording Reverse(const VioInput& input, std::span<const TrackedImage> images) {
  ReversedRecording reversed;
  const std::int64_t sum_ns = images.empty() ? 0 : images.front().stamp_ns + images.back().stamp_ns;
  reversed.samples.assign(input.samples.rbegin(), input.samples.rend());
  for (ImuSample& sample : reversed.samples) {
    sample.stamp_ns = sum_ns - sample.stamp_ns;
    sample.angular_velocity_rad_s = -sample.angular_velocity_rad_s;
  }
  reversed.images.assign(images.rbegin(), images.rend());
  for (TrackedImage& image : reversed.images) image.stamp_ns = sum_ns - image.stamp_ns;
  reversed.input = input;
  reversed.input.samples = reversed.samples;
  reversed.input.imu.time_offset_s = -input.imu.time_offset_s;
  reversed.input.camera.rolling_shutter_s = -input.camera.rolling_shutter_s;
  reversed.input.start.reset();
  return reversed;
}

Result<RigCalibration> CalibrateRig(const VioInput& input, std::span<const TrackedImage> images,
                                    const VioOptions& options, int most_passes,
                                    const WorkContext& work) {
  RigCalibration calibration;
  calibration.noise = MeasureStillestNoise(input.samples);
  VioInput forward = input;
  VioOptions of_pass = options;  // the read-out is the camera's: each pass begins with another
  if (options.rolling_shutter_s != 0) forward.camera.rolling_shutter_s = options.rolling_shutter_s;
  of_pass.rolling_shutter_s = 0;
  ReversedRecording reversed = Reverse(forward, images);
  for (int i = 0; i < most_passes && !calibration.agreed; ++i) {
    const bool backward = i % 2 == 1;
    const std::string stage = "pass " + std::to_string(i + 1);
    VioInput& present = backward ? reversed.input : forward;
    const VioRun run =
        RunVio(present, backward ? std::span<const TrackedImage>(reversed.images) : images, of_pass,
               {[&](const Progress& done) {
                  work.report({stage, done.done, done.total});
                },
                work.stop});
    if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    const std::int64_t first_ns = backward ? reversed.images.back().stamp_ns : images[0].stamp_ns;
    RigPass pass = PassOf(run, backward, first_ns);
    if (pass.estimates.empty()) {
      return Error{ErrorCode::kDegenerate,
                   std::string("no image got a pose") + (backward ? " when run backward" : "") +
                       (run.reports.empty() ? "" : ": " + run.reports.back().message)};
    }
    calibration.passes.push_back(std::move(pass));
    // The next pass begins where this one ended.
    const RigEstimate& end = calibration.passes.back().estimates.back();
    VioInput& next = backward ? forward : reversed.input;
    LensVector lens = end.lens;
    if (!backward) lens[kReadOut] *= -1;
    next.camera = WithLens(next.camera, lens);
    next.camera.body_from_cam = end.body_from_cam;
    next.imu.time_offset_s = backward ? end.time_offset_s : -end.time_offset_s;
    const auto last =
        std::find_if(run.reports.rbegin(), run.reports.rend(),
                     [](const auto& report) { return report.phase == VioPhase::kTracking; });
    const std::int64_t sum_ns = images.front().stamp_ns + images.back().stamp_ns;
    next.start = Turned(*last, sum_ns - last->stamp_ns);
    if (i == 0) continue;
    const RigEstimate& before = calibration.passes[calibration.passes.size() - 2].estimates.back();
    calibration.agreed = Agree(before, end);
    calibration.result = MeanOf(before, end);
  }
  if (calibration.passes.size() == 1) calibration.result = calibration.passes[0].estimates.back();
  return calibration;
}

}  // namespace plumbline
