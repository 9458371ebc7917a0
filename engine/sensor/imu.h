// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// What the IMU measured at one time, in `body` axes, biases included.
struct ImuSample {
  std::int64_t stamp_ns = 0;  ///< On the IMU's clock.
  Eigen::Vector3d angular_velocity_rad_s{0, 0, 0};
  Eigen::Vector3d specific_force_m_s2{0, 0, 0};  ///< At rest it points up, 9.8 m/s^2 long.
};

/// The noise of an IMU (continuous-time densities) and its clock, as imu.json describes them.
struct ImuCalibration {
  double rate_hz = 200;
  double gyro_noise_density = 1.6e-4;   ///< [rad/s/sqrt(Hz)]
  double accel_noise_density = 2.8e-3;  ///< [m/s^2/sqrt(Hz)]
  double gyro_bias_walk = 2.2e-5;       ///< [rad/s^2/sqrt(Hz)]
  double accel_bias_walk = 8.6e-4;      ///< [m/s^3/sqrt(Hz)]
  double time_offset_s = 0;             ///< time on the IMU's clock = time of an image + this
  double gravity_m_s2 = 9.81;
  std::optional<double> saturation_gyro_rad_s, saturation_accel_m_s2;
};

/// Missing keys keep their defaults, which are those of a phone. Errors: kInvalidInput for a value
/// that is not a number of its range, and where no key is known. `file` is only for messages.
Result<ImuCalibration> ImuCalibrationFromJson(const nlohmann::json& json,
                                              const std::filesystem::path& file);

}  // namespace plumbline
