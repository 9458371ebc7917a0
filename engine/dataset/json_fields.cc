// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/json_fields.h"

#include <nlohmann/json.hpp>

#include "engine/dataset/rigid_matrix.h"

namespace plumbline {

std::optional<Eigen::VectorXd> VectorFromJson(const nlohmann::json& json, int size) {
  if (!json.is_array() || json.size() != static_cast<std::size_t>(size)) return std::nullopt;
  Eigen::VectorXd vector(size);
  for (int i = 0; i < size; ++i) {
    if (!json[i].is_number()) return std::nullopt;
    vector[i] = json[i].get<double>();
  }
  if (!vector.allFinite()) return std::nullopt;
  return vector;
}

std::optional<Eigen::Isometry3d> IsometryFromJson(const nlohmann::json& json) {
  if (!json.is_array() || json.size() != 4) return std::nullopt;
  Eigen::Matrix4d matrix;
  for (int r = 0; r < 4; ++r) {
    const std::optional<Eigen::VectorXd> row = VectorFromJson(json[r], 4);
    if (!row) return std::nullopt;
    matrix.row(r) = *row;
  }
  return RigidFromMatrix(matrix);
}

nlohmann::json IsometryToJson(const Eigen::Isometry3d& isometry) {
  nlohmann::json json = nlohmann::json::array();
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) json[r][c] = isometry.matrix()(r, c);
  }
  return json;
}

std::optional<std::string> TextFromJson(const nlohmann::json& json, const char* key) {
  if (!json.is_object()) return std::nullopt;
  const auto found = json.find(key);
  if (found == json.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

}  // namespace plumbline
