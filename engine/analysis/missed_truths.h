// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "engine/analysis/run_review.h"
#include "engine/snapshot/playback_view.h"
#include "engine/snapshot/run_history.h"
#include "engine/snapshot/sequence_view.h"
#include "engine/snapshot/truths_view.h"

namespace plumbline {

/// Of an image's pixels, what has to show of an instance for it to be seen.
inline constexpr double kSeenShare = 0.002;
/// Seen in fewer frames, an instance counts as not seen.
inline constexpr int kFewestFramesSeen = 10;
/// An object no further from an instance than this, and turned no further, stands there.
inline constexpr float kThere_m = 0.15f, kThere_rad = 0.35f;

/// Every true instance of a run, and for those that the map lacks, why: worked out of what the
/// frames report (docs/algorithms/why_missed.md).
/// @param confirm_evidence  Log odds that confirm an object.
TruthsView TruthsOf(const RunHistory& history, std::span<const FrameEvent> events,
                    const SequenceView& view, double confirm_evidence);

TruthsView TruthsOf(const RunReview& review);

/// "not_seen", "never_boxed": the name of a cause in files.
const char* NameOf(MissedCause cause);
/// Why the map lacks an instance: `why` of `missed_instances` of `plumbline evaluate --json`.
nlohmann::json WhyMissedToJson(const TruthView& truth);
/// Null for an id that there is none of.
const TruthView* FindTruth(const TruthsView& truths, std::string_view id);

}  // namespace plumbline
