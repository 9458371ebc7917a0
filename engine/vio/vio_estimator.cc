// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/vio_estimator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "engine/base/check.h"
#include "engine/vio/clock_search.h"
#include "engine/vio/motion_start.h"
#include "engine/vio/rotation.h"
#include "engine/vio/start_refinement.h"
#include "engine/vio/start_state.h"

namespace plumbline {
namespace {

constexpr double kRestLookback = 0.5;  ///< Rest is judged over this time [s].
constexpr double kMotionWindow = 1.2;  ///< That a start in motion is aligned in [s].
/// A start in motion explains so much before the filter sees it [s].
constexpr double kSettleWindow = 3;
/// Between the images that it explains, at least [s].
constexpr double kSettleStep = 0.1;
constexpr double kMotionRetry = 0.4;  ///< Between attempts [s]; one costs as much as 20 images.
constexpr int kLateReadings = 10, kLateImages = 4;  ///< In a row: a clock was set back.
/// Clocks that are set back by nearly the same are one clock [s].
constexpr double kSameClock = 0.1;
constexpr double kMinMotion = 6;  ///< Points wander more when the body moves at all [px].

/// What the option says takes the place of what camera.json does.
Camera WithReadOut(Camera camera, const VioOptions& options) {
  if (options.rolling_shutter_s != 0) camera.rolling_shutter_s = options.rolling_shutter_s;
  return camera;
}

/// Images that are some time apart, the first one among them.
std::vector<TrackedImage> Thinned(const std::deque<TrackedImage>& window) {
  std::vector<TrackedImage> kept;
  for (const TrackedImage& image : window) {
    if (kept.empty() || image.stamp_ns - kept.back().stamp_ns >= Nanoseconds(0.95 * kSettleStep))
      kept.push_back(image);
  }
  return kept;
}

}  // namespace

VioEstimator::VioEstimator(const Camera& camera, const ImuCalibration& imu,
                           const VioOptions& options)
    : camera_(WithReadOut(camera, options)),
      calibration_(imu),
      options_(options),
      imu_(imu),
      rest_(options.rest_seconds + kRestLookback),
      filter_(camera_, imu, options),
      imu_clock_(kLateReadings),
      image_clock_(kLateImages) {
  PLB_CHECK(camera.body_from_cam.has_value());
}

void VioEstimator::Begin(InertialState inertial, StartSpread spread) {
  JoinLastStretch(inertial, spread);
  BeginWith(MakeStart(inertial, camera_, calibration_.time_offset_s, spread, options_));
}

void VioEstimator::JoinLastStretch(InertialState& inertial, StartSpread& spread) const {
  if (!last_good_) return;
  const double gap =
      std::max(0.0, static_cast<double>(inertial.stamp_ns - last_good_->stamp_ns) * 1e-9 -
                        calibration_.time_offset_s);
  const Eigen::Matrix3d before = last_good_->world_from_body.linear();
  // The heading that brings the two attitudes nearest; the gyro is not trusted over the gap.
  const Eigen::Matrix3d turn = before * inertial.world_from_body.transpose();
  const double yaw = std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
  const Eigen::Matrix3d heading = RotationExp({0, 0, yaw});
  inertial.world_from_body = heading * inertial.world_from_body;
  inertial.velocity_in_world = heading * inertial.velocity_in_world;
  inertial.position_in_world = last_good_->world_from_body.translation();
  const auto variance = last_good_->covariance.diagonal();
  const double wandered = gap * std::max(1.0, last_good_->velocity_in_world.norm());
  spread.position_m = std::hypot(std::sqrt(variance.head<3>().maxCoeff()), wandered);
  spread.yaw_rad = std::hypot(std::sqrt(variance(5)), std::min(0.5 * gap, 1.5));
}

void VioEstimator::BeginWith(const FilterState& state) {
  filter_.Start(state);
  health_.Reset();
  tracking_ = true;
  ++stretch_;
  clock_suspect_ = false;
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
  Begin(inertial, StartSpread());
  given_.reset();
  return true;
}

std::string VioEstimator::TryRestStart(const TrackedImage& image) {
  const auto motion = rest_.WanderWithin(options_.rest_seconds);
  if (!motion) {
    char text[60];
    std::snprintf(text, sizeof(text), "waiting for %.1f s of images", options_.rest_seconds);
    return text;
  }
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
  const Result<RestStart> start = StartFromRest(samples, calibration_, options_);
  if (!start.ok()) return start.error().message;
  InertialState inertial = start->inertial;
  StartSpread spread = start->spread;
  JoinLastStretch(inertial, spread);
  FilterState state = MakeStart(inertial, camera_, calibration_.time_offset_s, spread, options_);
  UpdateWithForce(start->force, calibration_.gravity_m_s2, state);
  BeginWith(state);
  return "";
}

void VioEstimator::SeekClock(std::span<const TrackedImage> images) {
  constexpr double kReach = 1;              // [s]; what ForgetOldReadings() leaves
  constexpr double kMinShift = 0.015;       // [s]; less is left to the filter
  constexpr double kBetter = 0.85;          // of the residual
  constexpr double kFoundOffsetStd = 0.02;  // [s]
  const Eigen::Vector3d bias = last_good_ ? last_good_->gyro_bias : Eigen::Vector3d::Zero();
  const auto fit = SearchClock(camera_, imu_, bias, images, calibration_.time_offset_s, kReach);
  if (!fit) return;
  const double shift = fit->offset_s - calibration_.time_offset_s;
  if (std::abs(shift) < kMinShift || fit->residual_px > kBetter * fit->given_residual_px) return;
  clock_shift_s_ += shift;
  calibration_.time_offset_s += shift;
  options_.time_offset_std_s = std::max(options_.time_offset_std_s, kFoundOffsetStd);
  char text[160];
  std::snprintf(text, sizeof(text),
                "a clock has jumped: images and gyro agree with an offset of %.3f s (%.3f s more)",
                fit->offset_s, shift);
  notes_ = WithNotes(text);
}

std::string VioEstimator::TryMotionStart() {
  const std::int64_t begin_ns = window_.front().stamp_ns;
  const double looked = static_cast<double>(window_.back().stamp_ns - begin_ns) * 1e-9;
  if (looked < 0.9 * kSettleWindow) {
    char text[100];
    std::snprintf(text, sizeof(text), "starting in motion: %.1f of %.1f s looked at", looked,
                  kSettleWindow);
    return text;
  }
  std::vector<TrackedImage> images;
  for (const TrackedImage& image : window_) {
    if (image.stamp_ns <= begin_ns + Nanoseconds(kMotionWindow)) images.push_back(image);
  }
  const double span = static_cast<double>(images.back().stamp_ns - images.front().stamp_ns) * 1e-9;
  if (span < 0.8 * kMotionWindow || images.size() < 5) return "waiting for images";
  if (clock_suspect_) SeekClock(images);
  const Result<MotionStart> motion = AlignInMotion(camera_, calibration_, imu_, images);
  if (!motion.ok()) return motion.error().message;
  InertialState guess;
  guess.stamp_ns = images.front().stamp_ns + Nanoseconds(calibration_.time_offset_s);
  guess.world_from_body = UprightRotation(-motion->gravity_in_body);
  guess.velocity_in_world = guess.world_from_body * motion->velocity_in_body;
  guess.gyro_bias = motion->gyro_bias;
  const auto refined = RefineStart(camera_, calibration_, imu_, Thinned(window_), guess, options_);
  if (!refined) return "waiting for a start in motion: no motion explains the points";
  // The filter sees the same images again, so it begins with several times the spread that they
  // leave. Not with much more: in slow motion a velocity that may be anything gives no point a
  // depth, and without points the filter never learns it.
  StartSpread spread;
  spread.tilt_rad = 0.02;
  spread.velocity_m_s = std::clamp(
      std::max(5 * refined->velocity_std_m_s, 0.1 * refined->inertial.velocity_in_world.norm()),
      0.02, 1.0);
  spread.gyro_bias_rad_s = 0.005;
  spread.accel_bias_m_s2 = options_.start_accel_bias_std_m_s2;
  InertialState inertial = refined->inertial;
  // The heading of a start is nothing that could be known.
  inertial.world_from_body = UprightRotation(inertial.world_from_body.transpose().col(2));
  inertial.velocity_in_world =
      inertial.world_from_body *
      (refined->inertial.world_from_body.transpose() * refined->inertial.velocity_in_world);
  Begin(inertial, spread);
  return "";
}

std::string VioEstimator::TryStart(const TrackedImage& image) {
  if (given_) return TryGivenStart(image) ? "" : "waiting for the time of the given start";
  std::string waits = TryRestStart(image);
  if (tracking_) {
    window_.assign(1, image);
    return "";
  }
  const auto wander = rest_.WanderWithin(options_.rest_seconds);
  if (!wander || *wander < kMinMotion) return waits;
  const std::int64_t now = image.stamp_ns;
  if (last_attempt_ns_ && now - *last_attempt_ns_ < Nanoseconds(kMotionRetry)) return waits;
  last_attempt_ns_ = now;
  return TryMotionStart();
}

void VioEstimator::Restart() {
  tracking_ = false;
  rest_.Clear();
  window_.clear();
}

void VioEstimator::MoveClock(std::int64_t later_ns, const char* whose) {
  calibration_.time_offset_s -= clock_shift_s_;
  clock_shift_s_ += static_cast<double>(later_ns) * 1e-9;
  if (std::abs(clock_shift_s_) < kSameClock) clock_shift_s_ = 0;
  calibration_.time_offset_s += clock_shift_s_;
  char text[120];
  std::snprintf(text, sizeof(text), "the %s clock was set back by %.2f s: starting anew", whose,
                std::abs(static_cast<double>(later_ns)) * 1e-9);
  notes_ = WithNotes(text);
  Restart();
}

std::string VioEstimator::WithNotes(std::string message) {
  if (left_out_ > 0) {
    notes_ += (notes_.empty() ? "" : "; ") + std::to_string(left_out_) +
              " of the images came twice or late and were left out";
    left_out_ = 0;
  }
  if (!notes_.empty()) message = notes_ + (message.empty() ? "" : "; ") + message;
  notes_.clear();
  return message;
}

void VioEstimator::AddImu(const ImuSample& sample) {
  if (imu_clock_.Add(sample.stamp_ns) == StampWatch::Verdict::kJumpedBack) {
    imu_.Clear();
    MoveClock(-imu_clock_.jump_ns(), "IMU's");
  }
  imu_.Add(sample);
}

std::vector<VioReport> VioEstimator::AddImage(const TrackedImage& image) {
  switch (image_clock_.Add(image.stamp_ns)) {
    case StampWatch::Verdict::kRises:
      break;
    case StampWatch::Verdict::kLate:
      ++left_out_;
      return {};
    case StampWatch::Verdict::kJumpedBack:
      left_out_ = 0;
      MoveClock(image_clock_.jump_ns(), "camera's");
      last_image_ns_.reset();
      last_step_ns_.reset();
      last_attempt_ns_.reset();
      if (last_good_) last_good_->stamp_ns -= image_clock_.jump_ns();
  }
  if (last_image_ns_) {
    const double since = static_cast<double>(image.stamp_ns - *last_image_ns_) * 1e-9;
    if (since < 0.9 / options_.max_rate_hz) return {};
  }
  last_image_ns_ = image.stamp_ns;
  rest_.Add(image);
  if (tracking_) return {Filter(image)};
  window_.push_back(image);
  while (window_.front().stamp_ns < image.stamp_ns - Nanoseconds(kSettleWindow))
    window_.pop_front();
  VioReport waiting;
  waiting.stamp_ns = image.stamp_ns;
  waiting.stretch = stretch_;
  if (given_) window_.assign(1, image);
  const std::string waits = TryStart(image);
  if (!tracking_) {
    waiting.message = WithNotes(waits);
    ForgetOldReadings(image.stamp_ns);
    return {waiting};
  }
  std::vector<VioReport> reports;
  for (const TrackedImage& past : window_) {
    if (tracking_) reports.push_back(Filter(past));
  }
  window_.clear();
  return reports;
}

VioReport VioEstimator::Filter(const TrackedImage& image) {
  const double since =
      last_step_ns_ ? static_cast<double>(image.stamp_ns - *last_step_ns_) * 1e-9 : 0;
  last_step_ns_ = image.stamp_ns;
  const auto wander = rest_.WanderWithin(kRestLookback);
  const bool resting = window_.size() <= 1 && wander && *wander < options_.zero_velocity_px;
  const FilterStep step = filter_.Step(image, imu_, resting);
  VioReport report = Report(image, step);
  report.resting = resting;
  const Health health = health_.Check(filter_.state(), step, since);
  report.message = WithNotes(health.message);
  if (health.lost) {
    report.phase = VioPhase::kWaiting;
    clock_suspect_ = health.disagrees;
    Restart();
  } else if (report.message.empty() || !last_good_) {
    last_good_ = report;  // what is in trouble may be wrong already
  }
  ForgetOldReadings(image.stamp_ns);
  return report;
}

void VioEstimator::ForgetOldReadings(std::int64_t image_ns) {
  const double memory = std::max(options_.rest_seconds, kSettleWindow) + 2 * kRestLookback;
  imu_.DropBefore(ImuTimeOf(image_ns) - Nanoseconds(memory));
}

std::int64_t VioEstimator::ImuTimeOf(std::int64_t image_ns) const {
  return image_ns +
         Nanoseconds(tracking_ ? filter_.state().time_offset_s() : calibration_.time_offset_s);
}

std::optional<FilterState> VioEstimator::Predict(std::int64_t image_ns) const {
  if (!tracking_) return std::nullopt;
  FilterState state = filter_.state();
  const std::vector<ImuSegment> segments =
      imu_.Between(state.inertial().stamp_ns, ImuTimeOf(image_ns));
  if (!segments.empty()) state.Propagate(Integrate(state.inertial(), segments, filter_.noise()));
  return state;
}

Eigen::Matrix3d VioEstimator::CamRotation(std::int64_t previous_ns, std::int64_t present_ns) const {
  const Eigen::Vector3d bias =
      tracking_ ? filter_.state().inertial().gyro_bias : Eigen::Vector3d::Zero();
  const Eigen::Matrix3d body_from_cam =
      (tracking_ ? filter_.state().body_from_cam() : *camera_.body_from_cam).linear();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  for (const ImuSegment& segment : imu_.Between(ImuTimeOf(previous_ns), ImuTimeOf(present_ns))) {
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
  report.covariance = state.PoseCovariance(options_.covariance_inflation);
  report.velocity_in_world = state.inertial().velocity_in_world;
  report.gyro_bias = state.inertial().gyro_bias;
  report.accel_bias = state.inertial().accel_bias;
  report.body_from_cam = state.body_from_cam();
  report.time_offset_s = state.time_offset_s();
  const Eigen::VectorXd spread =
      state.InflatedCovariance(options_.covariance_inflation).diagonal().cwiseMax(0).cwiseSqrt();
  report.spread = spread.segment<13>(kGyroBias);
  report.lens = state.lens();
  report.lens_spread = spread.segment<kLensSize>(kLens);
  report.step = step;
  return report;
}

}  // namespace plumbline
