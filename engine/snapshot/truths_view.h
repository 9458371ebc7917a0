// SPDX-License-Identifier: Apache-2.0
#pragma once

// The true instances of a run: which of them the map has, and why it has not the others.
// engine/analysis works it out.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/ids.h"

namespace plumbline {

enum class ProposalFate : std::uint8_t;  // mapping/map_report.h

/// What keeps a true instance out of the map, over a whole run (docs/algorithms/why_missed.md).
enum class MissedCause {
  kNone,          ///< It is in the map.
  kNotSeen,       ///< It hardly shows in any frame.
  kNotConfirmed,  ///< A candidate is there and waits for evidence.
  kWithdrawn,     ///< A candidate was there and is gone.
  kNeverBoxed,    ///< No proposal of its category lies over it.
  kNeverNear,     ///< Candidates were about, none came there.
  kBoxTaken,      ///< The proposals over it went to an object that is not it.
  kBirthRefused   ///< The proposals over it spawned nothing.
};

/// What became of the proposals over an instance, by what they were used for.
struct BoxUse {
  ProposalFate fate;
  ObjectId object;  ///< That took it or was born of it; not valid: none.
  int frames = 0;
};

/// An object that was near the instance at some time.
struct NearCandidate {
  ObjectId object;
  int first_frame = 0;
  float first_m = 0;  ///< Between origins.
  int nearest_frame = 0;
  float nearest_m = 0, nearest_rad = 0;        ///< When it was nearest.
  float last_m = 0, last_rad = 0;              ///< When it was last looked at.
  float last_std_m = 0, last_std_rad = 0;      ///< Of its belief then; rad 0: a round shape.
  float most_evidence = 0, last_evidence = 0;  ///< Log odds that it exists.
  bool confirmed = false;                      ///< At some time.
  std::optional<int> ended;                    ///< Frame; nothing: it lives.
  std::string end;                             ///< Why, as the mapper said it.
};

/// A true instance, over all frames that are known.
struct TruthView {
  std::string id, model, category;
  ObjectId object;      ///< That it is paired with in the newest frame; not valid: none.
  bool found = false;   ///< By a confirmed one.
  int frames = 0;       ///< That are known.
  int frames_seen = 0;  ///< In which enough of it shows.
  int first_seen = -1, last_seen = -1;
  int best_frame = -1;  ///< In which most of it shows.
  float best_visible_px = 0;
  int frames_boxed = 0;
  std::vector<BoxUse> boxes;              ///< By falling number of frames.
  std::vector<NearCandidate> candidates;  ///< By nearness.
  MissedCause cause = MissedCause::kNone;
  std::string text;  ///< The same as a sentence, with figures.
};

struct TruthsView {
  std::vector<TruthView> truths;  ///< As in SequenceView::truth.
  int found = 0, missed = 0;
};

}  // namespace plumbline
