// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"

namespace plumbline {

/// The lines `KEY: numbers` of a calibration file of KITTI; those that hold something else (a date)
/// are passed over.
using KittiCalibration = std::map<std::string, std::vector<double>>;
Result<KittiCalibration> ParseKittiCalibration(const std::filesystem::path& file);

/// A rectified camera: its intrinsics, and where it stands beside the first one.
struct KittiCamera {
  Camera camera;
  Eigen::Isometry3d cam_from_cam0 = Eigen::Isometry3d::Identity();  ///< Both rectified.
};
/// @param projection  3x4, row by row: K [I | t].
/// Errors: as CameraFromJson, and kCorrupt for other than 12 numbers.
Result<KittiCamera> CameraFromProjection(const std::vector<double>& projection, int width,
                                         int height, const std::filesystem::path& file);

/// A stamp `2011-09-26 13:02:25.964389445`, taken for UTC [ns].
std::optional<std::int64_t> ParseKittiStamp(std::string_view line);
/// The stamps of a timestamps.txt, one a line; a line that is none has no value.
Result<std::vector<std::optional<std::int64_t>>> KittiStamps(const std::filesystem::path& file);

/// One packet of the GPS and IMU, in which `body` is x forward, y left, z up: the data set's readme
/// says y right and z down, but its own ax, ay, az are front, left, top.
struct OxtsPacket {
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;
  double roll_rad = 0, pitch_rad = 0, yaw_rad = 0;  ///< Yaw 0 is east, rising towards north.
  ImuSample imu;                                    ///< Without its stamp.
};
/// The 30 numbers of oxts/data/NNNNNNNNNN.txt; nothing where it does not hold them.
std::optional<OxtsPacket> ParseOxts(std::string_view text);
/// world_from_body in a world with x east, y north, z up, of which `origin` is the origin: Mercator
/// at the latitude of the origin, as KITTI's development kit does it.
Eigen::Isometry3d PoseOf(const OxtsPacket& packet, const OxtsPacket& origin);

}  // namespace plumbline
