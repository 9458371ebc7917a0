// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/snapshot/batch_view.h"

namespace plumbline {

/// One value and the sequence that it is of.
struct SequenceValue {
  int sequence = 0;
  double value = 0;
};

/// The mean over sequences of their means over seeds, with its 95 % interval: Student's t over the
/// means of the sequences or, where there is one sequence, over its seeds. Nothing without a value.
/// See docs/batch.md for formulas and sources.
std::optional<MeanEstimate> EstimateMean(std::span<const SequenceValue> values);

/// The same of differences between two runs each, with the p-values of a sign-flip test (exact for
/// up to 20 pairs that differ, else 100 000 draws that are the same each time): on these sequences,
/// are the two the same but for the seed? Nothing without a pair.
std::optional<PairedDifference> ComparePairs(std::span<const SequenceValue> differences);

/// Holm's adjustment: all rows of which the adjusted p is at most 0.05 may be believed together.
std::vector<double> HolmAdjusted(std::span<const double> p);

}  // namespace plumbline
