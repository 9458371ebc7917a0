// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/rigid_matrix.h"

#include <string>
#include <string_view>

#include "engine/base/files.h"
#include "engine/dataset/text_table.h"
#include "engine/geometry/reach.h"

namespace plumbline {

std::optional<Eigen::Isometry3d> RigidFromMatrix(const Eigen::Matrix4d& matrix) {
  if (!matrix.allFinite() || (matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-9 ||
      matrix.topRightCorner<3, 1>().cwiseAbs().maxCoeff() > kFarthest_m)
    return std::nullopt;
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const double deviation =
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation < 1e-3) || rotation.determinant() < 0) return std::nullopt;
  Eigen::Isometry3d isometry(matrix);
  if (deviation > 1e-12)
    isometry.linear() = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
  return isometry;
}

std::optional<Eigen::Isometry3d> RigidFromRows(std::span<const double> numbers) {
  if (numbers.size() != 12 && numbers.size() != 16) return std::nullopt;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < numbers.size(); ++i)
    matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = numbers[i];
  return RigidFromMatrix(matrix);
}

Result<std::vector<double>> NumbersOf(const std::filesystem::path& file) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  std::vector<double> numbers;
  for (const std::string_view line : SplitLines(*text)) {
    for (const std::string_view field : SplitFields(line)) {
      const std::optional<double> number = ParseNumber(field);
      if (!number) {
        return Error{ErrorCode::kCorrupt, "'" + file.string() +
                                              "' holds something else than "
                                              "numbers"};
      }
      numbers.push_back(*number);
    }
  }
  return numbers;
}

}  // namespace plumbline
