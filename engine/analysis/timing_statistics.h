// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/run_history.h"
#include "engine/snapshot/timing_statistics.h"

namespace plumbline {

/// Statistics of all frames of a history that were read. Some milliseconds for 10 000 frames.
/// @param most_slow  How many of the slowest frames are listed.
TimingStatistics StatisticsOf(const RunHistory& history, int most_slow = 8);

}  // namespace plumbline
