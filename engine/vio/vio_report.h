// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/options.h"
#include "engine/vio/filter_state.h"

namespace plumbline {

enum class VioPhase { kWaiting, kTracking };
template <>
struct EnumNames<VioPhase> {
  static constexpr std::string_view names[] = {"waiting", "tracking"};
};

/// What one image did to the filter.
struct FilterStep {
  int tracks = 0;    ///< Points of the image that the filter follows.
  int points = 0;    ///< In the state, afterwards.
  int accepted = 0;  ///< Tracks and points whose measurements were used.
  int rejected = 0;  ///< Turned away by the gate.
  int without_depth =
      0;                 ///< Tracks that showed too little parallax, or did not agree with a point.
  double nis = 0;        ///< Sum of the normalised innovations squared that were gated ...
  int nis_dof = 0;       ///< ... and of their degrees of freedom; equal if the filter is honest.
  double imu_gap_s = 0;  ///< Time since the last image that no reading covers ...
  double imu_saturated_s = 0;  ///< ... or saturated ones do.
  double propagate_ms = 0, update_ms = 0;
};

/// What the visual-inertial estimator believes after one image.
struct VioReport {
  std::int64_t stamp_ns = 0;  ///< Of the image, on the camera's clock.
  VioPhase phase = VioPhase::kWaiting;
  /// What it waits for and how far it is, or what is wrong; "" while all is well.
  std::string message;
  int stretch = 0;  ///< Rises with each new start.
  bool resting = false;

  // While tracking, at the time of the image:
  Eigen::Isometry3d world_from_body = Eigen::Isometry3d::Identity();
  /// In the order of PosePerturbation (sensor/pose_estimate.h), of the body; like the spreads below
  /// the filter's, inflated (VioOptions::covariance_inflation).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d velocity_in_world{0, 0, 0};  ///< [m/s]
  Eigen::Vector3d gyro_bias{0, 0, 0};          ///< [rad/s]
  Eigen::Vector3d accel_bias{0, 0, 0};         ///< [m/s^2]
  Eigen::Isometry3d body_from_cam = Eigen::Isometry3d::Identity();
  double time_offset_s = 0;
  /// Standard deviations: gyro and accelerometer bias, camera rotation [rad], camera translation
  /// [m], time offset [s].
  Eigen::Matrix<double, 13, 1> spread = Eigen::Matrix<double, 13, 1>::Zero();
  /// The lens (filter_state.h) and its standard deviations, 0 of what is not estimated.
  LensVector lens = LensVector::Zero(), lens_spread = LensVector::Zero();
  FilterStep step;
};

}  // namespace plumbline
