// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/motion_start.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <vector>

#include <Eigen/Cholesky>

#include "engine/sensor/distorted_camera.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

constexpr int kMinSights = 5, kMinTracks = 15;
constexpr double kVelocityPrior = 2;     // [m/s]
constexpr double kGravityPrior = 1;      // [m/s^2] of the mean specific force from gravity
constexpr double kBiasPrior = 0.1;       // [rad/s]
constexpr double kMaxResidual = 6;       // [px]; an accelerometer's bias alone makes some
constexpr double kMinDepth = 0.2;        // [m]
constexpr double kTypicalDepth = 3;      // [m]
constexpr double kGravityLength = 0.02;  // [m/s^2]
constexpr int kRounds = 3;               // of Gauss-Newton

using Unknowns = Eigen::Matrix<double, 6, 1>;  // velocity, gravity; in the first body's axes
using UnknownsMatrix = Eigen::Matrix<double, 6, 6>;

/// The motion of the body in the first body's axes, without velocity and gravity.
struct WindowPose {
  double seconds = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d drift{0, 0, 0};  ///< The twice integrated specific force.
  Eigen::Vector3d speed{0, 0, 0};  ///< The once integrated one.
  Eigen::Vector3d angular_velocity{0, 0, 0};

  /// That of a row which is exposed so much later.
  WindowPose Later(double delay_s) const {
    WindowPose pose = *this;
    if (delay_s == 0) return pose;
    pose.seconds += delay_s;
    pose.rotation = rotation * RotationExp(delay_s * angular_velocity);
    pose.drift += delay_s * speed;
    return pose;
  }
};

struct WindowSight {
  std::size_t image;
  Eigen::Vector3d ray;  ///< In the body's axes.
  double delay_s;       ///< Of its row.
};

struct WindowTrack {
  std::vector<WindowSight> sights;
  double depth = 2;  ///< Along the first ray, of the last solution [m].
  double rms_px = 0;
  bool used = true;
};

/// rows: by_unknowns * y + by_depth * depth + constant = 0, in pixels.
struct TrackEquations {
  Eigen::Matrix<double, Eigen::Dynamic, 6> by_unknowns;
  Eigen::VectorXd by_depth, constant;
};

class Alignment {
 public:
  Alignment(const Camera& camera, const ImuCalibration& imu, const ImuBuffer& readings,
            std::span<const TrackedImage> images)
      : body_from_cam_(*camera.body_from_cam),
        focal_px_(camera.pinhole.fx),
        gravity_m_s2_(imu.gravity_m_s2) {
    const std::int64_t offset = Nanoseconds(imu.time_offset_s);
    for (std::size_t k = 0; k + 1 < images.size(); ++k) {
      segments_.push_back(
          readings.Between(images[k].stamp_ns + offset, images[k + 1].stamp_ns + offset));
    }
    const DistortedCamera lens(camera);
    std::map<std::int64_t, WindowTrack> tracks;
    for (std::size_t k = 0; k < images.size(); ++k) {
      for (const TrackedPoint& point : images[k].points) {
        if (const auto ray = lens.Unproject(point.pixel))
          tracks[point.id].sights.push_back(
              {k, body_from_cam_.linear() * *ray, camera.RowDelay(point.pixel.y())});
      }
    }
    for (auto& [id, track] : tracks) {
      if (static_cast<int>(track.sights.size()) >= kMinSights) tracks_.push_back(track);
    }
  }

  int num_tracks() const {
    return static_cast<int>(
        std::count_if(tracks_.begin(), tracks_.end(), [](const auto& t) { return t.used; }));
  }

  /// Residuals of all rows at the best velocity, gravity and depths for this bias [px].
  Eigen::VectorXd Solve(const Eigen::Vector3d& bias) {
    Integrate(bias);
    solved_ = false;
    SolveLinear(mean_gravity_, kGravityPrior);
    solved_ = true;
    for (int round = 0; round < kRounds; ++round) SolveLinear(mean_gravity_, kGravityPrior);
    // Then with gravity of its length.
    for (int round = 0; round < 2; ++round)
      SolveLinear(gravity_m_s2_ * unknowns.tail<3>().normalized(), kGravityLength);
    return Residuals();
  }

  void LeaveOutMismatches() {
    std::vector<double> rms;
    for (const WindowTrack& track : tracks_) rms.push_back(track.rms_px);
    std::nth_element(rms.begin(), rms.begin() + static_cast<std::ptrdiff_t>(rms.size() / 2),
                     rms.end());
    const double limit = std::max(2.0, 3 * rms[rms.size() / 2]);
    for (WindowTrack& track : tracks_) track.used = track.rms_px < limit;
  }

  double MedianResidual() const {
    std::vector<double> rms;
    for (const WindowTrack& track : tracks_) {
      if (track.used) rms.push_back(track.rms_px);
    }
    if (rms.empty()) return 1e9;
    std::nth_element(rms.begin(), rms.begin() + static_cast<std::ptrdiff_t>(rms.size() / 2),
                     rms.end());
    return rms[rms.size() / 2];
  }

  Unknowns unknowns = Unknowns::Zero();

 private:
  void Integrate(const Eigen::Vector3d& bias) {
    poses_.assign(1, {});
    Eigen::Vector3d speed = Eigen::Vector3d::Zero(), force = Eigen::Vector3d::Zero();
    for (const auto& between : segments_) {
      WindowPose pose = poses_.back();
      for (const ImuSegment& segment : between) {
        const double dt = segment.seconds();
        const Eigen::Vector3d turn = dt * (segment.angular_velocity_rad_s - bias);
        const Eigen::Vector3d a = segment.specific_force_m_s2;
        pose.drift += dt * speed + dt * dt * pose.rotation * (SecondIntegral(turn) * a);
        const Eigen::Vector3d gain = dt * pose.rotation * (LeftJacobian(turn) * a);
        speed += gain;
        force += gain;
        pose.angular_velocity = segment.angular_velocity_rad_s - bias;
        if (pose.seconds == 0) poses_.front().angular_velocity = pose.angular_velocity;
        pose.rotation = pose.rotation * RotationExp(turn);
        pose.seconds += dt;
      }
      pose.speed = speed;
      poses_.push_back(pose);
    }
    mean_gravity_ = -gravity_m_s2_ * force.normalized();
  }

  WindowPose PoseOf(const WindowSight& sight) const {
    return poses_[sight.image].Later(sight.delay_s);
  }

  /// The way from a sight's camera to the point is linear in the unknowns and the depth. What is
  /// minimised is the angle between it and the ray, linearised at the present solution; before
  /// there is one, its part across the ray at a typical depth. (Weights by the depths of an
  /// earlier round would let noise shrink the scene, round by round.)
  TrackEquations EquationsOf(const WindowTrack& track) const {
    const auto rows = static_cast<Eigen::Index>(3 * (track.sights.size() - 1));
    TrackEquations e{{}, Eigen::VectorXd(rows), Eigen::VectorXd(rows)};
    e.by_unknowns.resize(rows, 6);
    const WindowPose first = PoseOf(track.sights.front());
    const Eigen::Vector3d ray0 = first.rotation * track.sights.front().ray;
    for (std::size_t i = 1; i < track.sights.size(); ++i) {
      const WindowPose pose = PoseOf(track.sights[i]);
      const Eigen::Vector3d ray = pose.rotation * track.sights[i].ray;
      const double t0 = first.seconds, t = pose.seconds;
      Eigen::Matrix<double, 3, 6> by_unknowns;
      by_unknowns << (t0 - t) * Eigen::Matrix3d::Identity(),
          0.5 * (t0 * t0 - t * t) * Eigen::Matrix3d::Identity();
      const Eigen::Vector3d given = first.drift - pose.drift +
                                    (first.rotation - pose.rotation) * body_from_cam_.translation();
      Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
      const auto row = static_cast<Eigen::Index>(3 * (i - 1));
      if (!solved_) {
        across *= focal_px_ / kTypicalDepth;
        e.constant.segment<3>(row) = across * given;
      } else {
        const Eigen::Vector3d way = by_unknowns * unknowns + track.depth * ray0 + given;
        const double length = std::max(way.norm(), kMinDepth);
        const Eigen::Vector3d direction = way / length;
        const Eigen::Vector3d residual = focal_px_ * (across * direction);
        across *=
            focal_px_ / length * (Eigen::Matrix3d::Identity() - direction * direction.transpose());
        e.constant.segment<3>(row) =
            residual - across * (by_unknowns * unknowns + track.depth * ray0);
      }
      e.by_unknowns.middleRows<3>(row) = across * by_unknowns;
      e.by_depth.segment<3>(row) = across * ray0;
    }
    return e;
  }

  void SolveLinear(const Eigen::Vector3d& gravity, double gravity_std) {
    UnknownsMatrix information = UnknownsMatrix::Zero();
    Unknowns right = Unknowns::Zero();
    for (const WindowTrack& track : tracks_) {
      if (!track.used) continue;
      const TrackEquations e = EquationsOf(track);
      const double square = e.by_depth.squaredNorm() + 1e-9;
      const Unknowns along = e.by_unknowns.transpose() * e.by_depth;
      information += e.by_unknowns.transpose() * e.by_unknowns - along * along.transpose() / square;
      right -=
          e.by_unknowns.transpose() * e.constant - along * (e.by_depth.dot(e.constant) / square);
    }
    information.diagonal().head<3>().array() += 1 / (kVelocityPrior * kVelocityPrior);
    information.diagonal().tail<3>().array() += 1 / (gravity_std * gravity_std);
    right.tail<3>() += gravity / (gravity_std * gravity_std);
    const Unknowns next = information.ldlt().solve(right);
    for (WindowTrack& track : tracks_) {
      const TrackEquations e = EquationsOf(track);  // still at the present solution
      const double before = track.depth;
      track.depth =
          -e.by_depth.dot(e.by_unknowns * next + e.constant) / (e.by_depth.squaredNorm() + 1e-9);
      if (solved_ || track.depth <= 0)  // not from far to near in one step
        track.depth = std::max(track.depth, 0.3 * before);
    }
    unknowns = next;
  }

  Eigen::VectorXd Residuals() {
    std::vector<double> all;
    for (WindowTrack& track : tracks_) {
      const TrackEquations e = EquationsOf(track);
      const Eigen::VectorXd r = e.by_unknowns * unknowns + e.by_depth * track.depth + e.constant;
      track.rms_px = std::sqrt(r.squaredNorm() / static_cast<double>(r.size() / 3));
      if (track.depth < kMinDepth) track.rms_px += 10;  // behind the camera
      for (const double value : r) all.push_back(track.used ? value : 0);
    }
    return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

  Eigen::Isometry3d body_from_cam_;
  double focal_px_, gravity_m_s2_;
  std::vector<std::vector<ImuSegment>> segments_;
  std::vector<WindowPose> poses_;
  std::vector<WindowTrack> tracks_;
  Eigen::Vector3d mean_gravity_{0, 0, 0};
  bool solved_ = false;  ///< Unknowns and depths are a solution to linearise at.
};

/// One step of Gauss-Newton over the gyro's bias, with numerical derivatives.
Eigen::Vector3d BiasStep(Alignment& alignment, const Eigen::Vector3d& bias) {
  constexpr double kStep = 1e-3;
  const Eigen::VectorXd residual = alignment.Solve(bias);
  Eigen::MatrixXd jacobian(residual.size(), 3);
  for (int i = 0; i < 3; ++i) {
    jacobian.col(i) = (alignment.Solve(bias + kStep * Eigen::Vector3d::Unit(i)) - residual) / kStep;
  }
  Eigen::Matrix3d information = jacobian.transpose() * jacobian;
  information.diagonal().array() += 1 / (kBiasPrior * kBiasPrior);
  return bias - information.ldlt().solve(jacobian.transpose() * residual +
                                         bias / (kBiasPrior * kBiasPrior));
}

}  // namespace

Result<MotionStart> AlignInMotion(const Camera& camera, const ImuCalibration& imu,
                                  const ImuBuffer& readings, std::span<const TrackedImage> images) {
  const auto missing = [](const char* format, auto... values) {
    char text[160];
    std::snprintf(text, sizeof(text), format, values...);
    return Error{ErrorCode::kDegenerate, text};
  };
  Alignment alignment(camera, imu, readings, images);
  if (alignment.num_tracks() < kMinTracks) {
    return missing("waiting for a start in motion: %d points live long enough, %d are needed",
                   alignment.num_tracks(), kMinTracks);
  }
  constexpr int kSteps = 3;
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  for (int step = 0; step < kSteps; ++step) bias = BiasStep(alignment, bias);
  alignment.Solve(bias);
  alignment.LeaveOutMismatches();
  for (int step = 0; step < kSteps; ++step) bias = BiasStep(alignment, bias);
  alignment.Solve(bias);
  MotionStart start;
  start.residual_px = alignment.MedianResidual();
  start.tracks = alignment.num_tracks();
  if (!(start.residual_px < kMaxResidual) || start.tracks < kMinTracks) {
    return missing("waiting for a start in motion: points are off by %.1f px, at most %.1f",
                   start.residual_px, kMaxResidual);
  }
  start.velocity_in_body = alignment.unknowns.head<3>();
  start.gravity_in_body = imu.gravity_m_s2 * alignment.unknowns.tail<3>().normalized();
  start.gyro_bias = bias;
  return start;
}

}  // namespace plumbline
