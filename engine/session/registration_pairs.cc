// SPDX-License-Identifier: Apache-2.0
#include "engine/session/registration_pairs.h"

#include <exception>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/dataset/json_fields.h"
#include "engine/geometry/reach.h"

namespace plumbline {
namespace {

Eigen::VectorXd NumbersOf(const nlohmann::json& pair, const char* key, int size) {
  const auto numbers = VectorFromJson(pair.at(key), size);
  if (!numbers) throw std::invalid_argument(key);
  return *numbers;
}

Eigen::Vector3d PointOf(const nlohmann::json& pair, const char* key) {
  const Eigen::Vector3d point = NumbersOf(pair, key, 3);
  if (point.cwiseAbs().maxCoeff() > kFarthest_m) throw std::invalid_argument(key);
  return point;
}

void TakePair(const nlohmann::json& pair, RegistrationPairs& pairs) {
  const Eigen::Vector3d in_scan = PointOf(pair, "in_scan");
  if (pair.contains("in_world")) {
    pairs.in_world.push_back({in_scan, PointOf(pair, "in_world")});
  } else {
    pairs.in_frames.push_back(
        {in_scan, IntFromJson(pair.at("frame")), NumbersOf(pair, "pixel", 2)});
  }
}

}  // namespace

Result<RegistrationPairs> ReadRegistrationPairs(const std::filesystem::path& file) {
  const auto read = ReadJson(file);
  if (!read) return read.error();
  if (!read->is_array()) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + file.string() + "' must be a list of pairs: [{..}, {..}]"};
  }
  RegistrationPairs pairs;
  int number = 0;
  for (const nlohmann::json& pair : *read) {
    ++number;
    try {
      TakePair(pair, pairs);
    } catch (const std::exception&) {
      return Error{ErrorCode::kInvalidInput,
                   "'" + file.string() + "', pair " + std::to_string(number) +
                       ": a pair is {in_scan: [x, y, z], frame, pixel: [u, v]} or {in_scan, "
                       "in_world: [x, y, z]}"};
    }
  }
  return pairs;
}

}  // namespace plumbline
