// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/asl_sensor_file.h"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "engine/base/files.h"

namespace plumbline {
namespace {

/// The text without OpenCV's `%YAML:1.0`, which is no directive of YAML.
Result<YAML::Node> ReadYaml(const std::filesystem::path& file) {
  Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  if (text->starts_with("%YAML:")) text->erase(0, text->find('\n'));
  try {
    return YAML::Load(*text);
  } catch (const YAML::Exception& error) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' is not YAML: " + error.what()};
  }
}

nlohmann::json MatrixFrom(const std::vector<double>& numbers) {
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t row = 0; row < 4; ++row) {
    rows.push_back(std::vector<double>(numbers.begin() + static_cast<std::ptrdiff_t>(4 * row),
                                       numbers.begin() + static_cast<std::ptrdiff_t>(4 * row + 4)));
  }
  return rows;
}

}  // namespace

Result<Camera> ReadAslCamera(const std::filesystem::path& file) {
  const Result<YAML::Node> yaml = ReadYaml(file);
  if (!yaml.ok()) return yaml.error();
  try {
    const YAML::Node& node = *yaml;
    const auto size = node["resolution"].as<std::vector<double>>();
    const auto intrinsics = node["intrinsics"].as<std::vector<double>>();
    const auto pose = node["T_BS"]["data"].as<std::vector<double>>();
    const auto model = node["camera_model"].as<std::string>();
    const auto bends = node["distortion_model"].as<std::string>();
    if (size.size() != 2 || intrinsics.size() != 4 || pose.size() != 16) {
      return Error{ErrorCode::kCorrupt,
                   "'" + file.string() +
                       "' needs a resolution of 2, intrinsics of 4 and a T_BS of "
                       "16 numbers"};
    }
    const bool radial = bends == "radial-tangential" || bends == "radtan";
    if (model != "pinhole" || (!radial && bends != "equidistant")) {
      return Error{ErrorCode::kUnsupported,
                   "'" + file.string() + "' has a camera of the model '" + model + "' with '" +
                       bends +
                       "' distortion; this version reads pinhole with radial-tangential "
                       "or equidistant"};
    }
    return CameraFromJson(
        {{"width", size[0]},
         {"height", size[1]},
         {"fx", intrinsics[0]},
         {"fy", intrinsics[1]},
         {"cx", intrinsics[2]},
         {"cy", intrinsics[3]},
         {"model", radial ? "radial_tangential" : "equidistant"},
         {"distortion", node["distortion_coefficients"].as<std::vector<double>>()},
         {"rate_hz", node["rate_hz"].as<double>(20)},
         {"body_from_cam", MatrixFrom(pose)}},
        file);
  } catch (const YAML::Exception& error) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() +
                                          "' does not describe a camera of the ASL layout (" +
                                          error.what() + ")"};
  }
}

Result<ImuCalibration> ReadAslImu(const std::filesystem::path& file) {
  const Result<YAML::Node> yaml = ReadYaml(file);
  if (!yaml.ok()) return yaml.error();
  ImuCalibration imu;
  const auto read = [&](const char* key, double& value) {
    if ((*yaml)[key]) value = (*yaml)[key].as<double>();
  };
  try {
    read("rate_hz", imu.rate_hz);
    read("gyroscope_noise_density", imu.gyro_noise_density);
    read("accelerometer_noise_density", imu.accel_noise_density);
    read("gyroscope_random_walk", imu.gyro_bias_walk);
    read("accelerometer_random_walk", imu.accel_bias_walk);
  } catch (const YAML::Exception& error) {
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' has a value that is not a number (" + error.what() + ")"};
  }
  return imu;
}

}  // namespace plumbline
