// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "engine/base/result.h"

namespace plumbline {

/// The matrix as a rigid transform; its rotation is made orthonormal if it is one to 1e-3. Nothing
/// where it is not, or is farther from the origin than kFarthest_m.
std::optional<Eigen::Isometry3d> RigidFromMatrix(const Eigen::Matrix4d& matrix);

/// The same of 12 (3x4) or 16 (4x4) numbers, row by row.
std::optional<Eigen::Isometry3d> RigidFromRows(std::span<const double> numbers);

/// All numbers of a text file that holds nothing else, between spaces, commas and line ends; nan
/// and inf are numbers. Errors: kNotFound, kIo, kCorrupt, naming the file.
Result<std::vector<double>> NumbersOf(const std::filesystem::path& file);

}  // namespace plumbline
