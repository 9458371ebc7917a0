// SPDX-License-Identifier: Apache-2.0
#include "ui/files/clip_box_json.h"

#include <vector>

#include "engine/geometry/reach.h"
#include "ui/files/kept_value.h"

namespace plumbline {

nlohmann::json ToJson(const ClipBox& box) {
  const auto list = [](const auto& values) {
    return std::vector<double>(values.data(), values.data() + values.size());
  };
  return {{"world_from_upright", list(box.world_from_upright)},  // by columns
          {"low", list(box.in_upright.min())},
          {"high", list(box.in_upright.max())}};
}

std::optional<ClipBox> ClipBoxFromJson(const nlohmann::json& json) {
  const auto read = [&](const char* key, double* to, std::size_t count) {
    const auto found = json.find(key);
    if (found == json.end() || !found->is_array() || found->size() != count) return false;
    for (std::size_t i = 0; i < count; ++i) {
      if (!TakeValue((*found)[i], to[i])) return false;
    }
    return true;
  };
  ClipBox box;
  constexpr double kTolerance = 1e-6;
  const bool whole = read("world_from_upright", box.world_from_upright.data(), 9) &&
                     read("low", box.in_upright.min().data(), 3) &&
                     read("high", box.in_upright.max().data(), 3);
  if (!whole || box.in_upright.isEmpty() || !box.world_from_upright.isUnitary(kTolerance) ||
      box.in_upright.min().cwiseAbs().maxCoeff() > kFarthest_m ||
      box.in_upright.max().cwiseAbs().maxCoeff() > kFarthest_m)
    return std::nullopt;
  return box;
}

}  // namespace plumbline
