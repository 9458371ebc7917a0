// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/synthetic_options.h"

#include <cmath>
#include <cstdio>
#include <iterator>

namespace plumbline {
namespace {

/// Of KITTI's rectified cameras, at 1242 px of width (Geiger et al., IJRR 2013).
constexpr double kKittiFocal_px = 721.5377;
/// The sky is even: fewer rays leave no grain, and a street has many surfaces.
constexpr int kStreetLightRays = 16;
constexpr int kStreetSamples = 3;
constexpr double kLongestStreet_s = 60;

}  // namespace

std::optional<SyntheticScene> SyntheticSceneFromName(std::string_view name) {
  for (std::size_t i = 0; i < std::size(kSyntheticScenes); ++i) {
    if (kSyntheticScenes[i].name == name) return static_cast<SyntheticScene>(i);
  }
  return std::nullopt;
}

std::string_view NameOf(SyntheticScene scene) {
  return kSyntheticScenes[static_cast<std::size_t>(scene)].name;
}

SyntheticOptions OptionsFor(SyntheticScene scene) {
  const SyntheticSceneInfo& info = kSyntheticScenes[static_cast<std::size_t>(scene)];
  SyntheticOptions options;
  options.scene = scene;
  options.rate_hz = info.rate_hz;
  options.frames = info.frames;
  options.width = info.width;
  options.height = info.height;
  if (IsStreet(scene)) {
    options.light_rays = kStreetLightRays;
    options.samples_per_pixel = kStreetSamples;
  }
  if (scene == SyntheticScene::kStreet)
    options.horizontal_fov_rad = 2 * std::atan(0.5 * info.width / kKittiFocal_px);
  return options;
}

std::vector<std::string> SyntheticOptions::Validate() const {
  std::vector<std::string> problems;
  const auto within = [&](const char* what, double value, double low, double high) {
    if (!(value >= low && value <= high)) {
      char text[160];
      std::snprintf(text, sizeof(text), "%s must lie between %g and %g, not %g", what, low, high,
                    value);
      problems.push_back(text);
    }
  };
  within("frames", frames, 1, 100000);
  within("width", width, 64, 4096);
  within("height", height, 48, 4096);
  within("rate_hz", rate_hz, 1e-3, 1e4);
  if (horizontal_fov_rad) within("horizontal_fov_rad", *horizontal_fov_rad, 0.349, 2.618);
  within("rolling_shutter_s", rolling_shutter_s, -0.2, 0.2);
  within("samples_per_pixel", samples_per_pixel, 1, 64);
  within("light_rays", light_rays, 4, 1024);
  within("light_spacing", light_spacing, 0.5, 20);
  within("noise_levels", noise_levels, 0, 64);
  within("jpeg_quality", jpeg_quality, 1, 100);
  within("model_error", model_error, 0, 0.2);
  if (IsStreet(scene) && !(frames / rate_hz <= kLongestStreet_s))
    problems.push_back(
        "a street is filmed for a minute at most; give fewer frames or a higher rate");
  if (imu) {
    within("the IMU's rate", imu->rate_hz, 50, 2000);
    within("the IMU's noise", imu->noise, 0, 100);
    within("the gyro's bias", imu->gyro_bias_std_rad_s, 0, 1);
    within("the accelerometer's bias", imu->accel_bias_std_m_s2, 0, 5);
    within("the offset of the clocks", imu->time_offset_s, -0.5, 0.5);
    within("the wrong rotation of the camera", imu->wrong_rotation_rad, 0, 0.2);
    within("the wrong place of the camera", imu->wrong_translation_m, 0, 0.5);
    within("the rest at the start", imu->rest_s, 0, 3600);
    within("the tremor", imu->tremor, 0, 50);
  }
  if (tracks_only && !imu) problems.push_back("tracks alone are of use with an IMU only");
  const Eigen::Matrix3d rotation = world_from_room.linear();
  if (!(rotation * rotation.transpose()).isIdentity(1e-9) || rotation.determinant() < 0) {
    problems.push_back("world_from_room must be a rigid transform");
  }
  return problems;
}

}  // namespace plumbline
