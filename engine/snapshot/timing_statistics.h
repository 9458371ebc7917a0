// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the stages of a run took, over all frames that are known.

#include <string>
#include <vector>

namespace plumbline {

struct StageStatistics {
  std::string stage;
  double mean_ms = 0, median_ms = 0;
  double most_of_95_ms = 0;  ///< 95 % of the frames took no longer.
  double worst_ms = 0;
  int worst_frame = 0;
};

struct TimingStatistics {
  int frames = 0;
  std::vector<StageStatistics> stages;  ///< In the order in which the mapper goes through them; a
                                        ///< frame without a stage counts with 0 ms.
  StageStatistics all;                  ///< Of the sums.
  struct SlowFrame {
    int frame = 0;
    double total_ms = 0;
    std::string stage;  ///< The one that took longest there.
    double stage_ms = 0;
  };
  std::vector<SlowFrame> slowest;  ///< The slowest first.
};

}  // namespace plumbline
