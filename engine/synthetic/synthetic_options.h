// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

namespace plumbline {

/// `kRoom` is an ordinary furnished room; the others each hold one situation that is hard for a
/// mapper (docs/algorithms/synthetic.md).
enum class SyntheticScene {
  kRoom,
  kOcclusion,
  kClutter,
  kBlur,
  kLowContrast,
  kTruncation,
  kDuplicate,
  kVariant,
  kWall,
  kRows,
  kRevisit,
  kTwins,
  kOffice,
  kRates,
  kPlatform,
  kStreet,
  kPavement
};

/// What is told of a scene, and how long and how often it is filmed unless asked otherwise.
struct SyntheticSceneInfo {
  std::string_view name;
  std::string_view summary;
  double rate_hz = 30;
  int frames = 300;
  int width = 960, height = 500;  ///< [px]
};

/// In the order of the enumeration.
inline constexpr SyntheticSceneInfo kSyntheticScenes[] = {
    {"room", "a furnished living room; seed 1 is the demo"},
    {"occlusion", "a cabinet hides a chair for a while"},
    {"clutter", "many things that are no furniture"},
    {"blur", "one second of shaking every 2.5 seconds"},
    {"lowcontrast", "furniture in the colours of the room"},
    {"truncation", "the main group is cut by the image border"},
    {"duplicate", "split and double boxes"},
    {"variant", "an object differs from its model"},
    {"wall", "a wall without a model hides a chair for a minute", 10, 1060},
    {"rows", "12 equal chairs, 0.55 m apart", 10, 300},
    {"revisit", "back to the same furniture after 3 minutes and 60 m", 5, 1240},
    {"twins", "chairs that differ in their arm rests only"},
    {"office", "desks, office chairs, shelves, plants", 30, 450},
    {"rates", "the same walk for any --rate", 30, 450},
    {"platform", "half of the room stands 30 cm higher", 30, 450},
    {"street", "parked and moving cars, from a car", 10, 100, 1242, 375},
    {"pavement", "the same kind of street, from its pavement", 10, 200},
};

/// Whether it lies outdoors: a street instead of a room.
constexpr bool IsStreet(SyntheticScene scene) {
  return scene == SyntheticScene::kStreet || scene == SyntheticScene::kPavement;
}

std::optional<SyntheticScene> SyntheticSceneFromName(std::string_view name);
std::string_view NameOf(SyntheticScene scene);

/// An IMU on the body that carries the camera.
struct ImuSimulation {
  double rate_hz = 200;  ///< 50 .. 2000
  double noise = 1;  ///< Times the densities and walks of imu.json, which are a phone's; 0 .. 100
  double gyro_bias_std_rad_s = 0.01, accel_bias_std_m_s2 = 0.05;  ///< Of the biases at the start.
  /// True offset of the clocks, IMU time = image time + this; imu.json states 0. -0.5 .. 0.5 [s]
  double time_offset_s = 0;
  /// What camera.json's pose of the camera on the body is wrong by, about and along each axis, with
  /// signs by chance. 0 .. 0.2 [rad], 0 .. 0.5 [m]
  double wrong_rotation_rad = 0, wrong_translation_m = 0;
  double rest_s = 0;  ///< Without any motion but the tremor, at the start; 0 .. 3600
  double tremor = 0;  ///< Times that of a steady hand (8 to 12 Hz); 0 .. 50
};

/// What to make. Everything random follows from `seed`: the same options give the same files,
/// whatever the number of threads.
struct SyntheticOptions {
  SyntheticScene scene = SyntheticScene::kRoom;
  std::uint64_t seed = 1;
  int frames = 300;       ///< 1 .. 100000; longer walks go round again
  int width = 960;        ///< [px], 64 .. 4096; intrinsics scale with it
  int height = 500;       ///< [px], 48 .. 4096
  double rate_hz = 30.0;  ///< frames per second, > 0
  /// Field of view from left to right [rad], 20 .. 150 degrees; if not given, a focal length of
  /// 560 px for 960 px of width (81 degrees).
  std::optional<double> horizontal_fov_rad;
  /// From the first row of an image to the last [s], -0.2 .. 0.2; as camera.json states it.
  double rolling_shutter_s = 0;
  int samples_per_pixel =
      4;  ///< 1 .. 64; each has its own place in the pixel and time in the exposure
  int light_rays =
      128;  ///< 4 .. 1024; rays per light sample when the light of the room is computed
  double light_spacing = 1.0;  ///< 0.5 .. 20; spacing of light samples, 1 = a few centimetres.
  double noise_levels = 3.0;   ///< Sensor noise, standard deviation in grey levels of 256.
  int jpeg_quality = 92;       ///< 1 .. 100
  /// Every shape of the database is larger or smaller than what stands in the room by this share,
  /// by chance which; 0 .. 0.2. The room is the same.
  double model_error = 0;
  /// Boxes and edges as perfect networks would give them.
  bool flawless = false;
  /// With an IMU, the camera moves along a curve of continuous acceleration, some 0.01 mm off the
  /// walk's.
  std::optional<ImuSimulation> imu;
  /// Instead of images and all that belongs to them: tracked points (tracks.csv). Needs `imu`.
  bool tracks_only = false;
  /// The room is built z-up with the floor at 0; the sequence is written in `world`. Any rigid
  /// transform.
  Eigen::Isometry3d world_from_room = Eigen::Isometry3d::Identity();

  /// Every problem, one sentence each; empty when all is well.
  std::vector<std::string> Validate() const;
};

/// Those of a scene, filmed as long and as often as its story takes.
SyntheticOptions OptionsFor(SyntheticScene scene);

}  // namespace plumbline
