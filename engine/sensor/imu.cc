// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/imu.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace plumbline {

Result<ImuCalibration> ImuCalibrationFromJson(const nlohmann::json& json,
                                              const std::filesystem::path& file) {
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' " + what};
  };
  if (!json.is_object()) return bad("must hold a JSON object with the noise of the IMU");
  ImuCalibration imu;
  struct Key {
    const char* name;
    double* value;
    bool positive;
  };
  double gyro_limit = 0, accel_limit = 0;
  const Key keys[] = {{"rate_hz", &imu.rate_hz, true},
                      {"gyro_noise_density", &imu.gyro_noise_density, true},
                      {"accel_noise_density", &imu.accel_noise_density, true},
                      {"gyro_bias_walk", &imu.gyro_bias_walk, true},
                      {"accel_bias_walk", &imu.accel_bias_walk, true},
                      {"time_offset_s", &imu.time_offset_s, false},
                      {"gravity_m_s2", &imu.gravity_m_s2, true},
                      {"saturation_gyro_rad_s", &gyro_limit, true},
                      {"saturation_accel_m_s2", &accel_limit, true}};
  int known = 0;
  for (const Key& key : keys) {
    const auto found = json.find(key.name);
    if (found == json.end() || found->is_null()) continue;
    if (!found->is_number() || !std::isfinite(found->get<double>()) ||
        (key.positive && found->get<double>() <= 0)) {
      return bad("has a '" + std::string(key.name) + "' that is not a " +
                 (key.positive ? "positive" : "finite") + " number");
    }
    *key.value = found->get<double>();
    ++known;
  }
  if (known == 0) return bad("has none of the keys of an IMU, such as 'gyro_noise_density'");
  if (gyro_limit > 0) imu.saturation_gyro_rad_s = gyro_limit;
  if (accel_limit > 0) imu.saturation_accel_m_s2 = accel_limit;
  return imu;
}

}  // namespace plumbline
