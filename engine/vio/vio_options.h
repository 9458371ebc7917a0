// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/options.h"

namespace plumbline {

/// Everything that can be chosen about the visual-inertial filter; docs/algorithms/vio.md explains
/// each.
struct VioOptions {
  // Window and features
  int window_clones = 20;
  int state_features = 30;
  int max_tracks = 120;
  double max_rate_hz = 25;
  int min_observations = 4;
  double min_depth_m = 0.1;
  double max_depth_m = 100;
  double max_depth_spread = 0.5;

  // Noise
  double pixel_noise_px = 1.0;
  double creep_px = 0.1;
  double given_creep_px = 0.0;
  double image_jitter_px = 0.2;
  double image_jitter_m = 0.0005;
  double age_noise = 0.0;
  double blur_noise = 0.03;
  int max_point_age = 300;
  double rolling_shutter_s = 0;
  double imu_noise_factor = 1.5;
  double vibration_share = 0.3;
  double max_gyro_walk = 2e-4;
  double max_accel_walk = 4e-3;
  double gate_probability = 0.95;
  bool one_point_ransac = true;

  // What is told
  double covariance_inflation = 9;

  // What is estimated besides poses, velocity and biases
  bool estimate_extrinsics = true;
  bool estimate_time_offset = true;
  bool estimate_intrinsics = false;
  bool estimate_rolling_shutter = false;
  double extrinsic_rotation_std_deg = 0.3;
  double extrinsic_translation_std_m = 0.01;
  double time_offset_std_s = 0.003;
  double intrinsics_std_px = 3;
  double distortion_std = 0.005;
  double rolling_shutter_std_s = 0.01;

  // Start
  double still_px = 1.0;
  double rest_seconds = 1.2;
  double start_accel_bias_std_m_s2 = 0.1;

  // Zero velocity
  bool zero_velocity = true;
  double zero_velocity_px = 0.5;
  double zero_velocity_std_m_s = 0.02;
};

template <class Visitor>
void VisitFields(VioOptions& o, Visitor&& visit) {
  visit(o.window_clones, {"window_clones", "", "past poses that are kept in the state", 4, 40});
  visit(o.state_features, {"state_features", "", "long tracks that are kept in the state", 0, 200});
  visit(o.max_tracks, {"max_tracks", "", "tracks used at a time, the oldest first", 8, 2000});
  visit(o.max_rate_hz,
        {"max_rate_hz", "Hz", "images that follow faster are not used by the filter", 1, 1000});
  visit(o.min_observations,
        {"min_observations", "", "a track that ends earlier is not used", 2, 40});
  visit(o.min_depth_m, {"min_depth_m", "m", "nearer points are not believed", 0.01, 10});
  visit(o.max_depth_m, {"max_depth_m", "m", "points beyond count as this far", 1, 10000});
  visit(o.max_depth_spread,
        {"max_depth_spread", "", "a track whose depth is less certain, relatively, is not used",
         0.01, 10});
  visit(o.pixel_noise_px,
        {"pixel_noise_px", "px", "standard deviation of a tracked point", 0.05, 20});
  visit(
      o.creep_px,
      {"creep_px", "px",
       "what a patch followed through images strays by from one to the next: a random walk", 0, 5});
  visit(o.given_creep_px, {"given_creep_px", "px", "the same of tracks that are given", 0, 5});
  visit(o.image_jitter_px,
        {"image_jitter_px", "px",
         "what turns an image as a whole: exposure, rolling shutter, stamps", 0, 20});
  visit(o.image_jitter_m,
        {"image_jitter_m", "m", "what moves the camera of an image as a whole", 0, 1});
  visit(o.age_noise,
        {"age_noise", "", "what each image adds to the variance of a followed point, relatively", 0,
         10});
  visit(o.blur_noise,
        {"blur_noise", "",
         "of what the picture moves by from one image to the next, adds to a point's noise: blur; "
         "not of tracks that are given",
         0, 1});
  visit(o.max_point_age,
        {"max_point_age", "", "images after which a point of the state begins anew", 2, 1000000});
  visit(o.rolling_shutter_s,
        {"rolling_shutter_s", "s",
         "time from the first row of an image to the last; 0: as camera.json says", -0.2, 0.2});
  visit(o.imu_noise_factor,
        {"imu_noise_factor", "", "on the noise densities that imu.json states", 0.1, 100});
  visit(
      o.vibration_share,
      {"vibration_share", "",
       "of what readings scatter by, counts as noise where it is more than what is stated", 0, 10});
  visit(o.max_gyro_walk,
        {"max_gyro_walk", "rad/s^2/sqrt(Hz)",
         "limits what imu.json states: files of other filters hold inflated walks", 1e-8, 1});
  visit(o.max_accel_walk,
        {"max_accel_walk", "m/s^3/sqrt(Hz)",
         "limits what imu.json states: files of other filters hold inflated walks", 1e-8, 10});
  visit(o.gate_probability,
        {"gate_probability", "", "of honest measurements that pass the chi-squared gate", 0.5,
         0.99999});
  visit(o.one_point_ransac,
        {"one_point_ransac", "",
         "points of the state are used where most agree on a pose, the others where they pass the "
         "gate after that"});
  visit(o.covariance_inflation,
        {"covariance_inflation", "",
         "what errors of images cause in covariances that are told counts so many times: tracks on "
         "images err together for longer than the filter knows; not tracks that are given",
         1, 1000});
  visit(o.estimate_extrinsics,
        {"estimate_extrinsics", "", "refine the pose of the camera on the body"});
  visit(o.estimate_time_offset, {"estimate_time_offset", "", "refine the offset of the clocks"});
  visit(o.estimate_intrinsics,
        {"estimate_intrinsics", "",
         "refine focal lengths, centre and the first four coefficients of the lens"});
  visit(o.estimate_rolling_shutter,
        {"estimate_rolling_shutter", "", "refine the time from the first row to the last"});
  visit(o.extrinsic_rotation_std_deg,
        {"extrinsic_rotation_std_deg", "deg", "of the given camera pose, each axis", 1e-6, 20});
  visit(o.extrinsic_translation_std_m,
        {"extrinsic_translation_std_m", "m", "of the given camera pose, each axis", 1e-6, 1});
  visit(o.time_offset_std_s, {"time_offset_std_s", "s", "of the given offset", 1e-9, 0.1});
  visit(o.intrinsics_std_px,
        {"intrinsics_std_px", "px", "of the given focal lengths and centre", 1e-6, 1000});
  visit(o.distortion_std, {"distortion_std", "", "of each given coefficient of the lens", 1e-9, 1});
  visit(o.rolling_shutter_std_s,
        {"rolling_shutter_std_s", "s", "of the given rolling_shutter_s", 1e-9, 0.1});
  visit(o.still_px,
        {"still_px", "px", "at rest, points move less than this during rest_seconds", 0.05, 50});
  visit(o.rest_seconds, {"rest_seconds", "s", "rest that a start from rest needs", 0.2, 20});
  visit(o.start_accel_bias_std_m_s2, {"start_accel_bias_std_m_s2", "m/s^2",
                                      "of the accelerometer's bias at the start", 1e-4, 5});
  visit(o.zero_velocity, {"zero_velocity", "", "update with zero velocity while points rest"});
  visit(o.zero_velocity_px, {"zero_velocity_px", "px",
                             "median motion of the points below which the body rests", 0.01, 20});
  visit(o.zero_velocity_std_m_s,
        {"zero_velocity_std_m_s", "m/s", "of the velocity that rest allows", 1e-4, 1});
}

}  // namespace plumbline
