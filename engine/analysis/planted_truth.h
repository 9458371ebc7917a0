// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/ids.h"
#include "engine/recording/run_file.h"
#include "engine/snapshot/run_history.h"
#include "engine/snapshot/truths_view.h"

namespace plumbline {

/// What keeps an instance out of the map although the mapper was given its true pose.
enum class PlantedFate {
  kConfirmed,     ///< Nothing: only the search had not found it.
  kNotConfirmed,  ///< It stays, and waits for evidence.
  kWithdrawn,     ///< It stayed until the mapper gave it up.
  kMoved          ///< The likelihood drew it away.
};

/// A true instance that was given to a fork of its run as a candidate.
struct PlantedTruth {
  PlantedFate fate = PlantedFate::kMoved;
  int after = 0;    ///< The last frame of the run itself.
  ObjectId object;  ///< The candidate.
  std::string text;
};

/// The last frame before the instance shows well: at least half of what ever shows of it; the first
/// frame if it shows well from the start. Nothing for one that never shows.
/// @param index  Into SequenceView::truth.
std::optional<int> FrameToPlantAfter(const RunHistory& history, std::size_t index);

/// The object that the mapper made of what it was given, by the reason that it was given with
/// (PlantedObject::why).
ObjectId ObjectPlanted(std::span<const RunEvent> events, std::string_view why);

/// What became of `object`, which the mapper was given after the frame `after`.
/// @param truth  Of TruthsOf the fork.
PlantedTruth JudgePlanted(const TruthView& truth, ObjectId object, int after,
                          double confirm_evidence);

/// "search", "being there", "likelihood": what is to blame, in words.
const char* BlameOf(PlantedFate fate);
/// `planted` of `missed_instances` of `plumbline evaluate --plant --json`.
nlohmann::json PlantedToJson(const PlantedTruth& planted);

}  // namespace plumbline
