// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/kitti_files.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/text_table.h"
#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

constexpr std::size_t kOxtsNumbers = 30;

/// Of the development kit.
constexpr double kEarthRadius_m = 6378137;

Eigen::Vector3d MercatorOf(const OxtsPacket& packet, double scale) {
  return {scale * kEarthRadius_m * packet.longitude_deg * kRadPerDeg,
          scale * kEarthRadius_m * std::log(std::tan((90 + packet.latitude_deg) * kRadPerDeg / 2)),
          packet.altitude_m};
}

}  // namespace

Result<KittiCalibration> ParseKittiCalibration(const std::filesystem::path& file) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  KittiCalibration calibration;
  for (const std::string_view line : SplitLines(*text)) {
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) continue;
    std::vector<double> numbers;
    bool all = true;
    for (const std::string_view field : SplitFields(line.substr(colon + 1))) {
      const std::optional<double> number = ParseNumber(field);
      all = all && number.has_value() && std::isfinite(*number);
      numbers.push_back(number.value_or(0));
    }
    if (all) calibration[std::string(line.substr(0, colon))] = numbers;
  }
  return calibration;
}

Result<KittiCamera> CameraFromProjection(const std::vector<double>& projection, int width,
                                         int height, const std::filesystem::path& file) {
  if (projection.size() != 12) {
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' has a projection that is not 12 numbers"};
  }
  const std::vector<double>& p = projection;
  const nlohmann::json json = {{"width", width}, {"height", height}, {"model", "pinhole"},
                               {"fx", p[0]},     {"fy", p[5]},       {"cx", p[2]},
                               {"cy", p[6]},     {"rate_hz", 10}};
  const Result<Camera> camera = CameraFromJson(json, file);
  if (!camera.ok()) return camera.error();
  KittiCamera result{*camera, Eigen::Isometry3d::Identity()};
  // The last column is K t.
  result.cam_from_cam0.translation() << (p[3] - p[2] * p[11]) / p[0], (p[7] - p[6] * p[11]) / p[5],
      p[11];
  if (!(result.cam_from_cam0.translation().norm() < 100)) {
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' has a camera more than 100 m beside the first"};
  }
  return result;
}

std::optional<std::int64_t> ParseKittiStamp(std::string_view line) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
  const std::string text(line.substr(0, 60));
  if (std::sscanf(text.c_str(), "%4d-%2d-%2d %2d:%2d:%n", &year, &month, &day, &hour, &minute,
                  &used) != 5 ||
      used == 0)
    return std::nullopt;
  std::string_view seconds = std::string_view(text).substr(static_cast<std::size_t>(used));
  while (seconds.ends_with(' ')) seconds.remove_suffix(1);
  const std::optional<std::int64_t> rest = ParseStampNs(seconds);
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!rest || !date.ok() || year < 1970 || year > 2200 || hour < 0 || hour > 23 || minute < 0 ||
      minute > 59 || *rest < 0 || *rest > 61'000'000'000)
    return std::nullopt;
  const auto days = std::chrono::sys_days(date).time_since_epoch();
  return std::chrono::nanoseconds(days + std::chrono::hours(hour) + std::chrono::minutes(minute))
             .count() +
         *rest;
}

Result<std::vector<std::optional<std::int64_t>>> KittiStamps(const std::filesystem::path& file) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  std::vector<std::optional<std::int64_t>> stamps;
  for (const std::string_view line : SplitLines(*text)) stamps.push_back(ParseKittiStamp(line));
  return stamps;
}

std::optional<OxtsPacket> ParseOxts(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view line : SplitLines(text)) {
    for (const std::string_view field : SplitFields(line)) {
      const std::optional<double> number = ParseNumber(field);
      if (!number || !std::isfinite(*number)) return std::nullopt;
      numbers.push_back(*number);
    }
  }
  if (numbers.size() != kOxtsNumbers) return std::nullopt;
  const std::vector<double>& n = numbers;
  // lat lon alt roll pitch yaw vn ve vf vl vu ax ay az af al au wx wy wz wf wl wu ...
  OxtsPacket packet{n[0], n[1], n[2], n[3], n[4], n[5], {}};
  packet.imu.specific_force_m_s2 << n[11], n[12], n[13];
  packet.imu.angular_velocity_rad_s << n[17], n[18], n[19];
  if (!(std::abs(packet.latitude_deg) < 85) || !(std::abs(packet.longitude_deg) <= 180) ||
      !(std::abs(packet.altitude_m) < 1e5))
    return std::nullopt;
  return packet;
}

Eigen::Isometry3d PoseOf(const OxtsPacket& packet, const OxtsPacket& origin) {
  const double scale = std::cos(origin.latitude_deg * kRadPerDeg);
  Eigen::Isometry3d pose(Eigen::AngleAxisd(packet.yaw_rad, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(packet.pitch_rad, Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(packet.roll_rad, Eigen::Vector3d::UnitX()));
  pose.translation() = MercatorOf(packet, scale) - MercatorOf(origin, scale);
  return pose;
}

}  // namespace plumbline
