// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/vio_estimator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/base/check.h"
#include "engine/vio/rotation.h"
#include "engine/vio/start_state.h"

namespace plumbline {
namespace {

constexpr double kRestLookback = 0.5;  ///< Rest is judged against the image this long ago [s].

}  // namespace

VioEstimator::VioEstimator(const Camera& camera, const ImuCalibration& imu,
                           const VioOptions& options)
    : camera_(camera),
      calibration_(imu),
      options_(options),
      imu_(imu),
      rest_(options.rest_seconds + kRestLookback),
      filter_(camera, imu, options) {
  PLB_CHECK(camera.body_from_cam.has_value());
}

void VioEstimator::Begin(FilterState state) {
  filter_.Start(state);
  health_.Reset();
  tracking_ = true;
  ++stretch_;
}

bool VioEstimator::TryGivenStart(const TrackedImage& image) {
  const std::int64_t stamp = image.stamp_ns + Nanoseconds(calibration_.time_offset_s);
  if (!given_ || given_->stamp_ns > stamp) return false;
  InertialState inertial;
  inertial.stamp_ns = given_->stamp_ns;
  inertial.world_from_body = given_->world_from_body.linear();
  inertial.position_in_world = given_->world_from_body.translation();
  inertial.velocity_in_world = given_->velocity_in_world;
  inertial.gyro_bias = given_->gyro_bias;
  inertial.accel_bias = given_->accel_bias;
  Begin(MakeStart(inertial, *camera_.body_from_cam, calibration_.time_offset_s, StartSpread(),
                  options_));
  given_.reset();
  return true;
}

std::string VioEstimator::TryRestStart(const TrackedImage& image) {
  const auto motion = rest_.WanderWithin(options_.rest_seconds);
  if (!motion) return "waiting for " + std::to_string(options_.rest_seconds) + " s of images";
  if (*motion > options_.still_px) {
    char text[160];
    std::snprintf(text, sizeof(text),
                  "waiting for rest: points wandered by %.1f px in the last %.1f s, at most %.1f",
                  *motion, options_.rest_seconds, options_.still_px);
    return text;
  }
  const std::int64_t end = image.stamp_ns + Nanoseconds(calibration_.time_offset_s);
  const std::int64_t begin = end - Nanoseconds(options_.rest_seconds);
  std::vector<ImuSample> samples;
  for (const ImuSample& sample : imu_.samples()) {
    if (sample.stamp_ns >= begin && sample.stamp_ns < end) samples.push_back(sample);
  }
  if (samples.size() < 10) return "waiting for readings of the IMU";
  samples.push_back(*imu_.At(end));
  Result<FilterState> state =
      StartFromRest(samples, calibration_, *camera_.body_from_cam, options_);
  if (!state.ok()) return state.error().message;
  Begin(std::move(*state));
  return "";
}

std::optional<VioReport> VioEstimator::AddImage(const TrackedImage& image) {
  if (last_image_ns_) {
    const double since = static_cast<double>(image.stamp_ns - *last_image_ns_) * 1e-9;
    if (since < 0.9 / options_.max_rate_hz) return std::nullopt;
  }
  const double since =
      last_image_ns_ ? static_cast<double>(image.stamp_ns - *last_image_ns_) * 1e-9 : 0;
  last_image_ns_ = image.stamp_ns;
  rest_.Add(image);
  if (!tracking_) {
    VioReport report;
    report.stamp_ns = image.stamp_ns;
    report.stretch = stretch_;
    if (given_) {
      if (!TryGivenStart(image)) {
        report.message = "waiting for the time of the given start";
        return report;
      }
    } else {
      report.message = TryRestStart(image);
      if (!tracking_) return report;
    }
  }
  const auto motion = rest_.WanderWithin(kRestLookback);
  const bool resting = motion && *motion < options_.zero_velocity_px;
  const FilterStep step = filter_.Step(image, imu_, resting);
  VioReport report = Report(image, step);
  report.resting = resting;
  const Health health = health_.Check(filter_.state(), step, since);
  report.message = health.message;
  if (health.lost) {
    tracking_ = false;
    report.phase = VioPhase::kWaiting;
    rest_.Clear();
  } else {
    last_good_ = report;
  }
  imu_.DropBefore(image.stamp_ns - Nanoseconds(options_.rest_seconds + 2 * kRestLookback));
  return report;
}

Eigen::Matrix3d VioEstimator::CamRotation(std::int64_t previous_ns,
                                          std::int64_t present_ns) const {
  const bool tracking = tracking_;
  const std::int64_t offset = Nanoseconds(tracking ? filter_.state().time_offset_s()
                                                   : calibration_.time_offset_s);
  const Eigen::Vector3d bias =
      tracking ? filter_.state().inertial().gyro_bias : Eigen::Vector3d::Zero();
  const Eigen::Matrix3d body_from_cam =
      (tracking ? filter_.state().body_from_cam() : *camera_.body_from_cam).linear();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  for (const ImuSegment& segment : imu_.Between(previous_ns + offset, present_ns + offset)) {
    if (segment.noise_factor > 1) return Eigen::Matrix3d::Identity();
    turn = turn * RotationExp(segment.seconds() * (segment.angular_velocity_rad_s - bias));
  }
  return body_from_cam.transpose() * turn * body_from_cam;
}

VioReport VioEstimator::Report(const TrackedImage& image, const FilterStep& step) const {
  const FilterState& state = filter_.state();
  VioReport report;
  report.stamp_ns = image.stamp_ns;
  report.phase = VioPhase::kTracking;
  report.stretch = stretch_;
  report.world_from_body = state.inertial().pose();
  report.covariance = state.PoseCovariance();
  report.velocity_in_world = state.inertial().velocity_in_world;
  report.gyro_bias = state.inertial().gyro_bias;
  report.accel_bias = state.inertial().accel_bias;
  report.body_from_cam = state.body_from_cam();
  report.time_offset_s = state.time_offset_s();
  report.spread =
      state.covariance().diagonal().segment<13>(kGyroBias).cwiseMax(0).cwiseSqrt();
  report.step = step;
  return report;
}

}  // namespace plumbline
