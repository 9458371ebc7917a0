// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/evaluation/belief_report.h"

namespace plumbline {

/// An object that the map may hold, and the true one that it would stand for.
struct Candidate {
  double probability = 0;  ///< That it is there.
  std::string truth;       ///< Its id; empty: nothing true is near.
};

/// Precision and recall for every threshold that makes a difference. A true object counts once, for
/// the likeliest candidate; others that claim it are wrong.
/// @param truths  How many objects are really there.
PrecisionRecall PrecisionRecallOf(std::vector<Candidate> candidates, int truths);

}  // namespace plumbline
