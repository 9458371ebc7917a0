// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include <gmock/gmock.h>
#include <Eigen/Geometry>

namespace plumbline {

/// The root of this source tree.
std::filesystem::path SourceDirectory();
/// The program under test (build/bin/plumbline).
std::filesystem::path ProgramFile();
/// The real data that is not part of the project: PLUMBLINE_DATA, else `../shared` beside the
/// source tree; nothing where there is none. Tests then say GTEST_SKIP() << kNoSharedData.
std::optional<std::filesystem::path> SharedData();
inline constexpr const char* kNoSharedData =
    "the real data (../shared or PLUMBLINE_DATA) is not on this machine";

/// A fresh folder that is removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Absolute tolerances; rejects NaN; says both errors.
MATCHER_P3(IsometryNear, expected, rotation_tolerance_deg, translation_tolerance_m, "") {
  const Eigen::Isometry3d wanted = expected;
  const double angle = Eigen::AngleAxisd(wanted.linear().transpose() * arg.linear()).angle() *
                       180.0 / 3.14159265358979323846;
  const double distance = (wanted.translation() - arg.translation()).norm();
  *result_listener << "rotation off by " << angle << " deg, translation by " << distance << " m";
  return angle <= rotation_tolerance_deg && distance <= translation_tolerance_m;
}

}  // namespace plumbline
