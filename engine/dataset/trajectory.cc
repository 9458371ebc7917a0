// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/files.h"
#include "engine/dataset/text_table.h"
#include "engine/geometry/reach.h"

namespace plumbline {
namespace {

/// Farther from unit length than rounding in a file explains.
constexpr double kQuaternionTolerance = 0.01;

/// Appends the row's pose or says what is wrong with it.
std::optional<std::string_view> ReadRow(std::string_view line, std::vector<StampedPose>& poses) {
  const std::vector<std::string_view> fields = SplitFields(line);
  if (fields.size() != 8) return "not 8 numbers 't tx ty tz qx qy qz qw'; row left out";
  const std::optional<std::int64_t> stamp = ParseStampNs(fields[0]);
  if (!stamp) return "the stamp is not a number; row left out";
  std::array<double, 7> numbers;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::optional<double> number = ParseNumber(fields[i + 1]);
    if (!number) return "not 8 numbers 't tx ty tz qx qy qz qw'; row left out";
    if (!std::isfinite(*number)) return "the pose is not finite; row left out";
    numbers[i] = *number;
    if (i < 3 && std::abs(numbers[i]) > kFarthest_m)
      return "the pose is more than 1000 km from the origin; row left out";
  }
  const Eigen::Quaterniond rotation(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (!(std::abs(rotation.norm() - 1) < kQuaternionTolerance)) {
    return "the quaternion is not of unit length; row left out";
  }
  StampedPose pose{*stamp, Eigen::Isometry3d(rotation.normalized())};
  pose.world_from_cam.translation() << numbers[0], numbers[1], numbers[2];
  poses.push_back(pose);
  return std::nullopt;
}

}  // namespace

std::optional<Eigen::Isometry3d> Trajectory::Nearest(std::int64_t stamp_ns,
                                                     std::int64_t within_ns) const {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), stamp_ns,
                       [](const StampedPose& pose, std::int64_t t) { return pose.stamp_ns < t; });
  const StampedPose* best = nullptr;
  if (after != poses.end()) best = &*after;
  if (after != poses.begin() &&
      (best == nullptr || stamp_ns - std::prev(after)->stamp_ns <= best->stamp_ns - stamp_ns)) {
    best = &*std::prev(after);
  }
  if (best == nullptr || std::abs(best->stamp_ns - stamp_ns) > within_ns) return std::nullopt;
  return best->world_from_cam;
}

Result<Trajectory> ReadTrajectory(const std::filesystem::path& file,
                                  const std::optional<Eigen::Isometry3d>& body_from_cam) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  const std::vector<std::string_view> lines = SplitLines(text.value());
  const bool of_body = !lines.empty() && lines[0].starts_with('#') &&
                       lines[0].find("world_from_body") != std::string_view::npos;
  if (of_body && !body_from_cam) {
    return Error{
        ErrorCode::kInvalidInput,
        "'" + file.string() +
            "' holds poses of the body (world_from_body) but camera.json has no body_from_cam"};
  }
  Trajectory trajectory;
  LineWarnings warnings(file.string());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::size_t first = lines[i].find_first_not_of(" \t");
    if (first == std::string_view::npos || lines[i][first] == '#') continue;
    if (const auto problem = ReadRow(lines[i], trajectory.poses)) {
      warnings.Add(*problem, i + 1);
    } else if (trajectory.poses.size() > 1 &&
               trajectory.poses.back().stamp_ns < std::prev(trajectory.poses.end(), 2)->stamp_ns) {
      warnings.Add("the stamp is before the one above; rows sorted", i + 1);
    }
  }
  std::vector<StampedPose>& poses = trajectory.poses;
  if (poses.empty()) {
    const std::vector<std::string> why = warnings.Sentences();
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' holds no usable pose" +
                                          (why.empty() ? "" : ": " + why[0])};
  }
  const auto earlier = [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_ns < b.stamp_ns;
  };
  std::stable_sort(poses.begin(), poses.end(), earlier);
  const auto same = [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_ns == b.stamp_ns;
  };
  const std::size_t all = poses.size();
  poses.erase(std::unique(poses.begin(), poses.end(), same), poses.end());
  trajectory.warnings = warnings.Sentences();
  if (poses.size() < all) {
    trajectory.warnings.push_back("'" + file.string() + "' has " +
                                  std::to_string(all - poses.size()) +
                                  " poses with the stamp of another; the first of each counts");
  }
  if (of_body) {
    for (StampedPose& pose : poses) pose.world_from_cam = pose.world_from_cam * *body_from_cam;
  }
  return trajectory;
}

}  // namespace plumbline
