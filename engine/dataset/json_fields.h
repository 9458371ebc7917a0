// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

namespace plumbline {

/// A 4x4 matrix, row by row, as a rigid transform; its rotation is made orthonormal if it is one to
/// 1e-3. Nothing where it is not, or is farther from the origin than kFarthest_m.
std::optional<Eigen::Isometry3d> IsometryFromJson(const nlohmann::json& json);
nlohmann::json IsometryToJson(const Eigen::Isometry3d& isometry);

/// A list of exactly `size` finite numbers.
std::optional<Eigen::VectorXd> VectorFromJson(const nlohmann::json& json, int size);

/// The text under `key`; nothing where there is none.
std::optional<std::string> TextFromJson(const nlohmann::json& json, const char* key);

}  // namespace plumbline
