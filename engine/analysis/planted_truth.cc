// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/planted_truth.h"

#include <fmt/format.h>

#include <algorithm>

#include <nlohmann/json.hpp>

#include "engine/analysis/missed_truths.h"
#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

constexpr float kShowsWell = 0.5f;  ///< Of what ever shows.

const char* FileNameOf(PlantedFate fate) {
  switch (fate) {
    case PlantedFate::kConfirmed:
      return "confirmed";
    case PlantedFate::kNotConfirmed:
      return "not_confirmed";
    case PlantedFate::kWithdrawn:
      return "withdrawn";
    case PlantedFate::kMoved:
      return "moved";
  }
  return "";
}

}  // namespace

std::optional<int> FrameToPlantAfter(const RunHistory& history, std::size_t index) {
  float most = 0;
  for (const auto& frame : history.frames) {
    if (frame != nullptr && index < frame->truths.size())
      most = std::max(most, frame->truths[index].visible_px);
  }
  std::optional<int> before;
  for (const auto& frame : history.frames) {
    if (frame == nullptr || index >= frame->truths.size()) continue;
    if (most > 0 && frame->truths[index].visible_px >= kShowsWell * most)
      return before.value_or(frame->frame);
    before = frame->frame;
  }
  return std::nullopt;
}

ObjectId ObjectPlanted(std::span<const RunEvent> events, std::string_view why) {
  for (const RunEvent& event : events) {
    if (event.event.kind == EventKind::kSpawned && event.event.text == why)
      return event.event.object;
  }
  return {};
}

PlantedTruth JudgePlanted(const TruthView& truth, ObjectId object, int after,
                          double confirm_evidence) {
  PlantedTruth planted;
  planted.after = after;
  planted.object = object;
  const auto say = [&](PlantedFate fate, const std::string& text) {
    planted.fate = fate;
    planted.text = fmt::format("Given its true place after frame {}, {}.", after, text);
    return planted;
  };
  const auto candidate =
      std::find_if(truth.candidates.begin(), truth.candidates.end(),
                   [&](const NearCandidate& near) { return near.object == object; });
  if (candidate == truth.candidates.end()) {
    return say(PlantedFate::kMoved,
               fmt::format("object {} went away at once, or to another instance", object.value));
  }
  const std::string place = fmt::format("{:.0f} cm and {:.0f}\u00b0 from it",
                                        100 * candidate->last_m, kDegPerRad * candidate->last_rad);
  if (candidate->last_m > kThere_m || candidate->last_rad > kThere_rad) {
    const std::string end = candidate->ended ? fmt::format(" when it is given up in frame {} ({})",
                                                           *candidate->ended, candidate->end)
                                             : std::string();
    return say(PlantedFate::kMoved,
               fmt::format("object {} does not stay: it is {}{}", object.value, place, end));
  }
  if (candidate->ended) {
    return say(PlantedFate::kWithdrawn,
               fmt::format("object {} stays ({}) until frame {}: {}; its evidence had come to "
                           "{:.1f}, {:.1f} confirms",
                           object.value, place, *candidate->ended, candidate->end,
                           candidate->most_evidence, confirm_evidence));
  }
  if (truth.found && truth.object == object) {
    return say(PlantedFate::kConfirmed,
               fmt::format("object {} is confirmed and stands {} at the end", object.value, place));
  }
  return say(PlantedFate::kNotConfirmed,
             fmt::format("object {} stays ({}) and is not confirmed: evidence of {:.1f}, {:.1f} "
                         "confirms",
                         object.value, place, candidate->last_evidence, confirm_evidence));
}

const char* BlameOf(PlantedFate fate) {
  switch (fate) {
    case PlantedFate::kConfirmed:
      return "search";
    case PlantedFate::kNotConfirmed:
    case PlantedFate::kWithdrawn:
      return "being there";
    case PlantedFate::kMoved:
      return "likelihood";
  }
  return "";
}

nlohmann::json PlantedToJson(const PlantedTruth& planted) {
  return {{"fate", FileNameOf(planted.fate)},
          {"blame", BlameOf(planted.fate)},
          {"after", planted.after},
          {"object",
           planted.object.value > 0 ? nlohmann::json(planted.object.value) : nlohmann::json()},
          {"text", planted.text}};
}

}  // namespace plumbline
