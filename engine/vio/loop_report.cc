// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/loop_report.h"

#include <type_traits>

#include <nlohmann/json.hpp>

#include "engine/base/json_text.h"

namespace plumbline {

nlohmann::json ToJson(const LoopReport& report) {
  nlohmann::json closures = nlohmann::json::array();
  for (const LoopClosure& c : report.closures) {
    closures.push_back({{"image", c.image},
                        {"old_image", c.old_image},
                        {"closed_image", c.closed_image},
                        {"inliers", c.inliers},
                        {"moved_m", c.moved_m},
                        {"turned_deg", c.turned_deg},
                        {"trust", c.trust},
                        {"epoch", c.epoch}});
  }
  return {{"has_images", report.has_images},
          {"closed", report.believed()},
          {"epochs", report.epochs},
          {"key_frames", report.key_frames},
          {"alike", report.alike},
          {"turned_away", report.turned_away},
          {"unconfirmed", report.unconfirmed},
          {"largest_move_m", report.largest_move_m},
          {"largest_turn_deg", report.largest_turn_deg},
          {"last_move_m", report.last_move_m},
          {"last_turn_deg", report.last_turn_deg},
          {"ms", report.ms},
          {"bytes", report.bytes},
          {"closures", closures}};
}

LoopReport LoopReportFromJson(const nlohmann::json& json) {
  LoopReport report;
  const auto read = [](const nlohmann::json& from, const char* name, auto& field) {
    if constexpr (std::is_same_v<std::decay_t<decltype(field)>, int>) {
      if (from.contains(name)) field = IntFromJson(from.at(name));
    } else {
      field = from.value(name, field);
    }
  };
  read(json, "has_images", report.has_images);
  read(json, "epochs", report.epochs);
  read(json, "key_frames", report.key_frames);
  read(json, "alike", report.alike);
  read(json, "turned_away", report.turned_away);
  read(json, "unconfirmed", report.unconfirmed);
  read(json, "largest_move_m", report.largest_move_m);
  read(json, "largest_turn_deg", report.largest_turn_deg);
  read(json, "last_move_m", report.last_move_m);
  read(json, "last_turn_deg", report.last_turn_deg);
  read(json, "ms", report.ms);
  read(json, "bytes", report.bytes);
  for (const nlohmann::json& row : json.value("closures", nlohmann::json::array())) {
    LoopClosure& closure = report.closures.emplace_back();
    read(row, "image", closure.image);
    read(row, "old_image", closure.old_image);
    read(row, "closed_image", closure.closed_image);
    read(row, "inliers", closure.inliers);
    read(row, "moved_m", closure.moved_m);
    read(row, "turned_deg", closure.turned_deg);
    read(row, "trust", closure.trust);
    read(row, "epoch", closure.epoch);
  }
  return report;
}

}  // namespace plumbline
