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
  kVariant
};

inline constexpr std::string_view kSyntheticSceneNames[] = {
    "room", "occlusion", "clutter", "blur", "lowcontrast", "truncation", "duplicate", "variant"};

std::optional<SyntheticScene> SyntheticSceneFromName(std::string_view name);
std::string_view NameOf(SyntheticScene scene);

/// What to make. Everything random follows from `seed`: the same options give the same files,
/// whatever the number of threads.
struct SyntheticOptions {
  SyntheticScene scene = SyntheticScene::kRoom;
  std::uint64_t seed = 1;
  int frames = 300;       ///< 1 .. 100000; longer walks turn round and come back
  int width = 960;        ///< [px], 64 .. 4096; intrinsics scale with it
  int height = 500;       ///< [px], 48 .. 4096
  double rate_hz = 30.0;  ///< frames per second, > 0
  int samples_per_pixel =
      4;  ///< 1 .. 64; each has its own place in the pixel and time in the exposure
  int light_rays =
      128;  ///< 4 .. 1024; rays per light sample when the light of the room is computed
  double light_spacing = 1.0;  ///< 0.5 .. 20; spacing of light samples, 1 = a few centimetres.
  double noise_levels = 3.0;   ///< Sensor noise, standard deviation in grey levels of 256.
  int jpeg_quality = 92;       ///< 1 .. 100
  /// The room is built z-up with the floor at 0; the sequence is written in `world`. Any rigid
  /// transform.
  Eigen::Isometry3d world_from_room = Eigen::Isometry3d::Identity();

  /// Every problem, one sentence each; empty when all is well.
  std::vector<std::string> Validate() const;
};

}  // namespace plumbline
