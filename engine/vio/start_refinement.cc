// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/start_refinement.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "engine/sensor/distorted_camera.h"
#include "engine/vio/point_view.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

constexpr int kStartSize = 12;  // phi, xi_v, gyro bias, accelerometer bias
constexpr int kMinSights = 5, kMinTracks = 15;
constexpr int kMaxDescents = 30;
constexpr double kHeadingPrior = 1e-4;  // [rad]
constexpr double kVelocityPrior = 2;    // [m/s]
constexpr double kGyroBiasPrior = 0.1;  // [rad/s]
constexpr double kTrustedSigmas = 2;
constexpr double kMinDepth = 0.1, kMaxDepth = 100;  // [m]
// A track fits that has at most this mean of squares (robust), or so many times the median one.
constexpr double kMaxMisfit = 4, kMaxOfMedian = 2;
constexpr int kRoundsOfChoice = 4;

using StartVector = Eigen::Matrix<double, kStartSize, 1>;
using StartMatrix = Eigen::Matrix<double, kStartSize, kStartSize>;
using PoseByStart = Eigen::Matrix<double, 6, kStartSize>;

/// The body at an image, and how it moves with the start.
struct PathPose {
  double seconds = 0;  ///< Since the first image.
  Eigen::Isometry3d world_from_body;
  Eigen::Vector3d velocity_in_world, angular_velocity;  ///< The latter in the body's axes.
  PoseByStart by_start;

  Eigen::Isometry3d Later(double delay_s) const {
    if (delay_s == 0) return world_from_body;
    Eigen::Isometry3d moved = world_from_body;
    moved.linear() = moved.linear() * RotationExp(delay_s * angular_velocity);
    moved.translation() += delay_s * velocity_in_world;
    return moved;
  }
};

struct PathSight {
  std::size_t image;
  Eigen::Vector2d pixel;
  double delay_s;  ///< Of its row.
};

struct PathTrack {
  std::vector<PathSight> sights;
  Eigen::Vector3d value;  ///< (X/Z, Y/Z, 1/Z) in the camera of the first sight.
  bool used = true;
};

/// What one track says once its point is eliminated.
struct TrackTerm {
  StartMatrix information = StartMatrix::Zero();
  StartVector right = StartVector::Zero();
  Eigen::Matrix<double, 3, kStartSize> point_by_start;  ///< The point follows the start so,
  Eigen::Vector3d point_step;                           ///< and moves by this besides.
  double cost = 0;
};

double RobustCost(double square) {
  const double size = std::sqrt(square);
  return size < kTrustedSigmas ? 0.5 * square : kTrustedSigmas * (size - 0.5 * kTrustedSigmas);
}

class PathFit {
 public:
  PathFit(const Camera& camera, const ImuCalibration& imu, const ImuBuffer& readings,
          std::span<const TrackedImage> images, const VioOptions& options)
      : lens_(camera),
        body_from_cam_(*camera.body_from_cam),
        focal_px_(camera.pinhole.fx),
        options_(options) {
    noise_.gravity_m_s2 = imu.gravity_m_s2;
    accel_density_ = std::max(imu.accel_noise_density * options.imu_noise_factor, 1e-4);
    const std::int64_t offset = Nanoseconds(imu.time_offset_s);
    for (std::size_t k = 0; k + 1 < images.size(); ++k)
      segments_.push_back(
          readings.Between(images[k].stamp_ns + offset, images[k + 1].stamp_ns + offset));
    std::map<std::int64_t, PathTrack> tracks;
    for (std::size_t k = 0; k < images.size(); ++k) {
      for (const TrackedPoint& point : images[k].points)
        tracks[point.id].sights.push_back({k, point.pixel, camera.RowDelay(point.pixel.y())});
    }
    for (auto& [id, track] : tracks) {
      if (static_cast<int>(track.sights.size()) < kMinSights) continue;
      const auto ray = lens_.Unproject(track.sights.front().pixel);
      if (!ray || ray->z() < 0.05) continue;
      track.value << ray->x() / ray->z(), ray->y() / ray->z(), 0.5;
      tracks_.push_back(track);
    }
  }

  int num_tracks() const {
    return static_cast<int>(
        std::count_if(tracks_.begin(), tracks_.end(), [](const PathTrack& t) { return t.used; }));
  }

  void WalkFrom(const InertialState& start) {
    path_.clear();
    Integration integration{start};
    for (std::size_t k = 0; k <= segments_.size(); ++k) {
      PathPose pose;
      pose.seconds = static_cast<double>(integration.state.stamp_ns - start.stamp_ns) * 1e-9;
      pose.world_from_body = integration.state.pose();
      pose.velocity_in_world = integration.state.velocity_in_world;
      const auto& near = segments_[std::min(k, segments_.size() - 1)];
      pose.angular_velocity =
          near.empty() ? Eigen::Vector3d(0, 0, 0)
                       : Eigen::Vector3d(near.front().angular_velocity_rad_s - start.gyro_bias);
      const InertialMatrix& moved = integration.transition;
      for (const auto& [to, from] : {std::pair{0, kPhi}, {3, kXiP}}) {
        pose.by_start.middleRows<3>(to) << moved.block<3, 3>(from, kPhi),
            moved.block<3, 3>(from, kXiV), moved.block<3, 3>(from, kGyroBias),
            moved.block<3, 3>(from, kAccelBias);
      }
      path_.push_back(pose);
      if (k < segments_.size()) {
        for (const ImuSegment& segment : segments_[k]) IntegrateStep(segment, noise_, integration);
      }
    }
  }

  /// Points from the present path alone.
  void PlacePoints() {
    for (PathTrack& track : tracks_) {
      track.value.z() = 0.5;
      for (int step = 0; step < 5; ++step) {
        const TrackTerm term = TermOf(track);
        track.value = Stepped(track.value, term.point_step);
      }
    }
  }

  /// The cost of path and points, and what would lessen it.
  double Linearise(const InertialState& start, StartMatrix& information, StartVector& right) {
    information.setZero();
    right.setZero();
    double sum = AddPriors(start, information, right);
    terms_.clear();
    for (PathTrack& track : tracks_) {
      terms_.push_back(TermOf(track));
      if (!track.used) continue;
      information += terms_.back().information;
      right += terms_.back().right;
      sum += terms_.back().cost;
    }
    return sum;
  }

  void MovePoints(const StartVector& step) {
    for (std::size_t i = 0; i < tracks_.size(); ++i)
      tracks_[i].value =
          Stepped(tracks_[i].value, terms_[i].point_step - terms_[i].point_by_start * step);
  }

  std::vector<Eigen::Vector3d> points() const {
    std::vector<Eigen::Vector3d> values;
    for (const PathTrack& track : tracks_) values.push_back(track.value);
    return values;
  }
  void SetPoints(const std::vector<Eigen::Vector3d>& values) {
    for (std::size_t i = 0; i < tracks_.size(); ++i) tracks_[i].value = values[i];
  }

  /// Leaves out what fits much worse than most does, and takes in what fits by now.
  /// @return whether anything changed.
  bool ChooseTracks() {
    std::vector<double> misfits;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      const auto numbers = static_cast<double>(2 * tracks_[i].sights.size() - 3);
      misfits.push_back(2 * terms_[i].cost / numbers);
    }
    std::vector<double> sorted = misfits;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double limit = std::max(kMaxMisfit, kMaxOfMedian * *middle);
    bool changed = false;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      const bool fits = misfits[i] < limit;
      changed |= fits != tracks_[i].used;
      tracks_[i].used = fits;
    }
    return changed;
  }

 private:
  static Eigen::Vector3d Stepped(const Eigen::Vector3d& value, Eigen::Vector3d step) {
    step.z() = std::clamp(step.z(), -1.0, 1.0);
    Eigen::Vector3d moved = MovedPoint(value, step);
    moved.z() = std::clamp(moved.z(), 1 / kMaxDepth, 1 / kMinDepth);
    return moved;
  }

  double AddPriors(const InertialState& start, StartMatrix& information, StartVector& right) const {
    const auto add = [&](int row, double std, const Eigen::Vector3d& value) {
      information.diagonal().segment<3>(row).array() += 1 / (std * std);
      right.segment<3>(row) -= value / (std * std);
      return 0.5 * value.squaredNorm() / (std * std);
    };
    information(2, 2) += 1 / (kHeadingPrior * kHeadingPrior);
    return add(3, kVelocityPrior, start.velocity_in_world) +
           add(6, kGyroBiasPrior, start.gyro_bias) +
           add(9, options_.start_accel_bias_std_m_s2, start.accel_bias);
  }

  TrackTerm TermOf(const PathTrack& track) const {
    TrackTerm term;
    const PathSight& first = track.sights.front();
    const PathPose& anchor = path_[first.image];
    const AnchoredPoint point =
        PlacePoint(body_from_cam_, anchor.Later(first.delay_s), track.value);
    Eigen::Matrix3d by_point = 1e-3 * Eigen::Matrix3d::Identity();
    Eigen::Matrix<double, 3, kStartSize> mixed = Eigen::Matrix<double, 3, kStartSize>::Zero();
    Eigen::Vector3d point_right = Eigen::Vector3d::Zero();
    for (const PathSight& sight : track.sights) {
      const PathPose& pose = path_[sight.image];
      const auto view =
          ViewPoint(lens_, body_from_cam_, pose.Later(sight.delay_s), point.point_in_world);
      if (!view) {
        term.cost += RobustCost(400);
        continue;
      }
      // A sight strays by its own noise, by the creep of its patch, and by what the IMU's noise
      // moves the camera by since the first sight.
      const double since = pose.seconds - anchor.seconds;
      const double wander_m = accel_density_ * std::sqrt(since * since * since / 3);
      const double wander_px = wander_m * focal_px_ / std::max(view->point_in_cam.z(), kMinDepth);
      const double variance = options_.pixel_noise_px * options_.pixel_noise_px +
                              options_.creep_px * options_.creep_px * since * options_.max_rate_hz +
                              wander_px * wander_px;
      const Eigen::Vector2d residual = sight.pixel - view->pixel;
      const double square = residual.squaredNorm() / variance;
      term.cost += RobustCost(square);
      const double weight =
          (square > kTrustedSigmas * kTrustedSigmas ? kTrustedSigmas / std::sqrt(square) : 1) /
          variance;
      const Eigen::Matrix<double, 2, kStartSize> by_start =
          view->by_pose * pose.by_start + view->by_point * point.by_anchor * anchor.by_start;
      const Eigen::Matrix<double, 2, 3> by_value = view->by_point * point.by_value;
      term.information += weight * by_start.transpose() * by_start;
      term.right += weight * by_start.transpose() * residual;
      by_point += weight * by_value.transpose() * by_value;
      mixed += weight * by_value.transpose() * by_start;
      point_right += weight * by_value.transpose() * residual;
    }
    const Eigen::Matrix3d inverse = by_point.inverse();
    term.point_by_start = inverse * mixed;
    term.point_step = inverse * point_right;
    term.information -= mixed.transpose() * term.point_by_start;
    term.right -= mixed.transpose() * term.point_step;
    return term;
  }

  DistortedCamera lens_;
  Eigen::Isometry3d body_from_cam_;
  double focal_px_;
  double accel_density_;
  VioOptions options_;
  IntegrationNoise noise_;
  std::vector<std::vector<ImuSegment>> segments_;
  std::vector<PathPose> path_;
  std::vector<PathTrack> tracks_;
  std::vector<TrackTerm> terms_;
};

InertialState Moved(const InertialState& start, const StartVector& step) {
  InertialState moved = start;
  const Eigen::Matrix3d turn = RotationExp(step.head<3>());
  moved.world_from_body = Orthonormal(turn * start.world_from_body);
  moved.velocity_in_world =
      turn * start.velocity_in_world + LeftJacobian(step.head<3>()) * step.segment<3>(3);
  moved.position_in_world = turn * start.position_in_world;
  moved.gyro_bias += step.segment<3>(6);
  moved.accel_bias += step.segment<3>(9);
  return moved;
}

/// Levenberg and Marquardt. @return what is known of the start where it came to rest.
StartMatrix Minimise(PathFit& fit, InertialState& start) {
  StartMatrix information;
  StartVector right;
  fit.WalkFrom(start);
  double cost = fit.Linearise(start, information, right);
  double damping = 1e-4;
  for (int step = 0; step < kMaxDescents; ++step) {
    StartMatrix damped = information;
    damped.diagonal() *= 1 + damping;
    const StartVector change = damped.ldlt().solve(right);
    const InertialState next = Moved(start, change);
    const auto points = fit.points();
    fit.MovePoints(change);
    fit.WalkFrom(next);
    StartMatrix next_information;
    StartVector next_right;
    const double next_cost = fit.Linearise(next, next_information, next_right);
    if (!(next_cost < cost)) {
      fit.SetPoints(points);
      fit.WalkFrom(start);
      fit.Linearise(start, information, right);
      damping *= 10;
      if (damping > 1e4) break;
      continue;
    }
    const bool rests = cost - next_cost < 1e-5 * cost;
    start = next;
    cost = next_cost;
    information = next_information;
    right = next_right;
    damping = std::max(damping / 10, 1e-8);
    if (rests) break;
  }
  return information;
}

}  // namespace

std::optional<RefinedStart> RefineStart(const Camera& camera, const ImuCalibration& imu,
                                        const ImuBuffer& readings,
                                        std::span<const TrackedImage> images,
                                        const InertialState& guess, const VioOptions& options) {
  if (images.size() < 2) return std::nullopt;
  PathFit fit(camera, imu, readings, images, options);
  if (fit.num_tracks() < kMinTracks) return std::nullopt;
  InertialState start = guess;
  fit.WalkFrom(start);
  fit.PlacePoints();
  StartMatrix information = Minimise(fit, start);
  for (int round = 0; round < kRoundsOfChoice && fit.ChooseTracks(); ++round) {
    if (fit.num_tracks() < kMinTracks) return std::nullopt;
    information = Minimise(fit, start);
  }
  const StartMatrix covariance = information.inverse();
  if (!start.world_from_body.allFinite() || !start.velocity_in_world.allFinite() ||
      !covariance.allFinite())
    return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> velocity(covariance.block<3, 3>(3, 3));
  return RefinedStart{start, std::sqrt(std::max(0.0, velocity.eigenvalues()(2))), fit.num_tracks()};
}

}  // namespace plumbline
