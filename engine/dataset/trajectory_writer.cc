// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/trajectory_writer.h"

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/files.h"
#include "engine/dataset/sequence_writing.h"
#include "engine/dataset/stamped_rows.h"
#include "engine/dataset/text_table.h"

namespace plumbline {
Status WriteTrajectory(const std::filesystem::path& file, std::string_view frames,
                       std::span<const WrittenPose> poses) {
  std::string text = "# " + std::string(frames) + ": t[s] tx ty tz[m] qx qy qz qw\n";
  for (const WrittenPose& pose : poses) {
    const Eigen::Vector3d t = pose.world_from_sensor.translation();
    const Eigen::Quaterniond q(pose.world_from_sensor.linear());
    char row[200];
    std::snprintf(row, sizeof(row), " %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", t.x(), t.y(), t.z(),
                  q.x(), q.y(), q.z(), q.w());
    text += StampText(pose.stamp_ns) + row;
  }
  return WriteFileAtomically(file, text);
}

std::filesystem::path CovarianceFileOf(const std::filesystem::path& trajectory) {
  std::filesystem::path file = trajectory;
  file.replace_extension(".covariance.csv");
  return file;
}

Status WriteCovariances(const std::filesystem::path& file, std::string_view frames,
                        std::span<const WrittenPose> poses) {
  std::string text = "# t[s], then the 6x6 covariance of the error of " + std::string(frames) +
                     " row by row; order x y z [m] rx ry rz [rad], all along the axes of world: "
                     "t = t_estimate + (x y z), R = Exp(rx ry rz) R_estimate\n";
  for (const WrittenPose& pose : poses) {
    text += StampText(pose.stamp_ns);
    for (int row = 0; row < 6; ++row) {
      for (int column = 0; column < 6; ++column) {
        char number[32];
        std::snprintf(number, sizeof(number), ",%.9e", pose.covariance(row, column));
        text += number;
      }
    }
    text += '\n';
  }
  return WriteFileAtomically(file, text);
}

Result<Covariances> ReadCovariances(const std::filesystem::path& file) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  Covariances read;
  if (const std::string_view first = SplitLines(*text).empty() ? "" : SplitLines(*text).front();
      first.starts_with('#')) {
    read.of_body = first.find("world_from_body") != std::string_view::npos;
    read.independent = first.find("independent") != std::string_view::npos;
  }
  auto warnings = ReadStampedRows(
      file, {"t and the 36 numbers of a 6x6 covariance", 36},
      [&](std::int64_t stamp_ns, std::span<const double> numbers) {
        read.rows.push_back(
            {stamp_ns,
             Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(numbers.data())});
      });
  if (!warnings.ok()) return warnings.error();
  read.warnings = std::move(warnings).value();
  if (read.rows.empty()) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() +
                                          "' holds no usable covariance; write the trajectory "
                                          "again, or remove this file to go without"};
  }
  MakeStampsRise(file, "covariances", read.rows, read.warnings);
  return read;
}

}  // namespace plumbline
