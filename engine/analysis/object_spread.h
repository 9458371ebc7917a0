// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/frame_analysis.h"
#include "engine/snapshot/sequence_view.h"

namespace plumbline {

struct ObjectReport;

/// How far the belief about an object spreads, where the reported covariance is that of its
/// heaviest mode alone: over all of its particles; over its modes where the report comes without
/// particles.
///
/// Position: standard deviation about the mean of the models' centres, root of the sum over three
/// axes. Azimuth: the circular standard deviation modulo the symmetry of the heaviest mode's shape,
/// sqrt(-2 ln R) (Mardia and Jupp), at most that of an angle of which nothing is known; nothing for
/// a round shape.
ObjectSpread SpreadOf(const ObjectReport& object, const SequenceView& view);

/// The same over the modes, whether there are particles or not: a run's history comes without.
/// Modes are at most four, of 5 % of the weight each; what lies in none of them is left out. With
/// one mode, it is that of the covariance.
ObjectSpread SpreadOfModes(const ObjectReport& object, const SequenceView& view);

}  // namespace plumbline
