// SPDX-License-Identifier: Apache-2.0
#pragma once

// The small values of the mapper's report that are used without it: states, events, timings. They
// are apart from map_report.h so that a new field there compiles less again.

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "engine/base/ids.h"

namespace plumbline {

enum class ObjectState : std::uint8_t { kTentative, kConfirmed, kRetired };

/// The one table of names, as files have them.
constexpr std::string_view NameOf(ObjectState state) {
  constexpr std::array<std::string_view, 3> kNames = {"tentative", "confirmed", "retired"};
  return kNames.at(static_cast<std::size_t>(state));
}

struct LabelProbability {
  ModelId label;
  double probability = 0;
};

enum class EventKind : std::uint8_t {
  kSpawned,
  kConfirmed,
  kMerged,
  kRetired,
  kLabelChanged,
  kFrameSkipped,
  kOptionsChanged,  ///< of the mapper, from this frame on: `option_changes`
  kPosesCorrected   ///< of this frame, those before and those to come: `landmarks`
};

constexpr std::string_view NameOf(EventKind kind) {
  constexpr std::array<std::string_view, 8> kNames = {
      "spawned",       "confirmed",     "merged",          "retired",
      "label_changed", "frame_skipped", "options_changed", "poses_corrected"};
  return kNames.at(static_cast<std::size_t>(kind));
}

/// A name of these tables as people read it: "label changed".
inline std::string InWords(std::string_view name) {
  std::string words(name);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

/// What a frame that could not be used lacks.
enum class SkipCause : std::uint8_t {
  kUnknown,  ///< Or the frame was used. Run files keep the words alone.
  kImage,
  kPose,
  kEdges,
  kDetections
};

struct LifeEvent {
  EventKind kind = EventKind::kSpawned;
  ObjectId object;
  ObjectId other;              ///< kMerged: the object that goes on.
  std::string text;            ///< Why, in words; nothing is decided by it.
  std::string option_changes;  ///< kOptionsChanged: as of option_changes.h.
  std::string landmarks;       ///< kPosesCorrected: what corrected them, as of landmark_edge.h.
};

struct StageTiming {
  std::string stage;
  double milliseconds = 0;
};

}  // namespace plumbline
