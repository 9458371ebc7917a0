// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/stamp_statistics.h"

#include <vector>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(StampStatistics, TellRateSpanAndGaps) {
  const std::vector<std::int64_t> stamps = {0, 100000000, 200000000, 500000000, 600000000};
  const StampStatistics statistics = StatisticsOf(stamps, 1.5);
  EXPECT_NEAR(statistics.rate_hz(), 10, 1e-9);
  EXPECT_NEAR(statistics.span_s(), 0.6, 1e-12);
  EXPECT_NEAR(statistics.longest_step_s, 0.3, 1e-12);
  EXPECT_EQ(statistics.longest_after, 2);
  EXPECT_EQ(statistics.gaps, 1);
  EXPECT_EQ(StatisticsOf(stamps, 4).gaps, 0);
}

TEST(StampStatistics, OfOneStampOrNoneHaveNoRate) {
  EXPECT_EQ(StatisticsOf({}, 2).rate_hz(), 0);
  const std::vector<std::int64_t> one = {7};
  EXPECT_EQ(StatisticsOf(one, 2).first_ns, 7);
  EXPECT_EQ(StatisticsOf(one, 2).rate_hz(), 0);
}

}  // namespace
}  // namespace plumbline
