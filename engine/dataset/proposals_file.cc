// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/proposals_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

std::optional<Detection> ReadBox(const nlohmann::json& json) {
  static constexpr const char* kKeys[] = {"x0", "y0", "x1", "y1", "score"};
  if (!json.is_object()) return std::nullopt;
  float numbers[5];
  for (int i = 0; i < 5; ++i) {
    const auto found = json.find(kKeys[i]);
    if (found == json.end() || !found->is_number()) return std::nullopt;
    numbers[i] = found->get<float>();
    if (!std::isfinite(numbers[i])) return std::nullopt;
  }
  const std::optional<std::string> category = TextFromJson(json, "category");
  Detection detection{
      {numbers[0], numbers[1], numbers[2], numbers[3]}, category.value_or(""), numbers[4]};
  if (!category || detection.box.empty() || detection.score < 0 || detection.score > 1)
    return std::nullopt;
  return detection;
}

}  // namespace

nlohmann::json ProposalsToJson(const std::string& image, std::span<const Detection> proposals) {
  nlohmann::json boxes = nlohmann::json::array();
  for (const Detection& d : proposals) {
    boxes.push_back({{"x0", d.box.x0},
                     {"y0", d.box.y0},
                     {"x1", d.box.x1},
                     {"y1", d.box.y1},
                     {"category", d.category},
                     {"score", d.score}});
  }
  return {{"image", image}, {"boxes", boxes}};
}

Result<std::vector<Detection>> ReadProposalsFile(const std::filesystem::path& file) {
  const Result<nlohmann::json> read = ReadJson(file);
  if (!read.ok()) return read.error();
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kCorrupt, "the proposals '" + file.string() + "' " + what};
  };
  const nlohmann::json* boxes = &read.value();
  if (boxes->is_array() && boxes->size() == 1 && (*boxes)[0].is_object() &&
      (*boxes)[0].contains("boxes")) {
    boxes = &(*boxes)[0];
  }
  if (boxes->is_object() && boxes->contains("boxes")) boxes = &boxes->at("boxes");
  if (!boxes->is_array()) return bad("hold no list 'boxes'");
  std::vector<Detection> detections;
  for (const nlohmann::json& entry : *boxes) {
    const std::optional<Detection> detection = ReadBox(entry);
    if (!detection) {
      return bad("have a box " + std::to_string(detections.size()) +
                 " that is not {x0 < x1, y0 < y1, category, score in 0..1}");
    }
    detections.push_back(*detection);
  }
  return detections;
}

}  // namespace plumbline
