// SPDX-License-Identifier: Apache-2.0
#include "engine/models/model_source.h"

#include <optional>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/models/file_frame.h"

namespace plumbline {
namespace {

/// Nothing where the text does not describe a frame.
std::optional<Eigen::Isometry3d> FrameOf(const nlohmann::json& source) {
  const auto axis = [&source](const char* key) {
    return source.contains(key) && source[key].is_string()
               ? ParseSignedAxis(source[key].get_ref<const std::string&>())
               : std::nullopt;
  };
  const auto up = axis("up"), front = axis("front");
  const nlohmann::json& numbers = source["origin_m"];
  if (!up || !front || up->axis == front->axis || !numbers.is_array() || numbers.size() != 3)
    return std::nullopt;
  Eigen::Vector3d origin;
  for (int i = 0; i < 3; ++i) {
    const nlohmann::json& number = numbers[static_cast<std::size_t>(i)];
    if (!number.is_number()) return std::nullopt;
    origin[i] = number.get<double>();
  }
  Eigen::Isometry3d object_from_file = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d z = up->vector(), x = front->vector();
  object_from_file.linear() << x.transpose(), z.cross(x).transpose(), z.transpose();
  object_from_file.translation() = -(object_from_file.linear() * origin);
  if (!object_from_file.matrix().allFinite()) return std::nullopt;
  return object_from_file;
}

}  // namespace

Result<std::map<std::string, Eigen::Isometry3d, std::less<>>> ReadObjectFromFile(
    const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "models.json";
  const Result<nlohmann::json> json = ReadJson(file);
  if (!json.ok()) return json.error();
  const auto bad = [&file](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' " + what};
  };
  if (!json->is_object() || !json->contains("models") || !(*json)["models"].is_array())
    return bad("is no list of models");
  std::map<std::string, Eigen::Isometry3d, std::less<>> frames;
  for (const nlohmann::json& entry : (*json)["models"]) {
    if (!entry.is_object() || !entry.contains("name") || !entry["name"].is_string())
      return bad("has a model without name");
    if (!entry.contains("source") || !entry["source"].is_object() ||
        !entry["source"].contains("origin_m"))
      continue;
    const std::string name = entry["name"].get<std::string>();
    const auto frame = FrameOf(entry["source"]);
    if (!frame)
      return bad("describes the file of '" + name +
                 "' by something else than axes 'up' and 'front' and three numbers 'origin_m'");
    frames.emplace(name, *frame);
  }
  return frames;
}

}  // namespace plumbline
