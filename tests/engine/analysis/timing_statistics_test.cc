// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/timing_statistics.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

RunHistory HistoryOf(int frames) {
  RunHistory history;
  for (int i = 0; i < frames; ++i) {
    FrameSample sample;
    sample.frame = 10 * i;
    sample.timings = {{"update", static_cast<double>(i)}};
    if (i % 2 == 0) sample.timings.push_back({"birth", 100.0});
    history.frames.push_back(std::make_shared<const FrameSample>(sample));
  }
  return history;
}

TEST(TimingStatistics, AreOfAllFramesWhicheverWereShown) {
  const TimingStatistics statistics = StatisticsOf(HistoryOf(101));
  ASSERT_EQ(statistics.stages.size(), 2u);
  EXPECT_EQ(statistics.frames, 101);
  const StageStatistics& update = statistics.stages[0];
  EXPECT_EQ(update.stage, "update");
  EXPECT_DOUBLE_EQ(update.mean_ms, 50);
  EXPECT_DOUBLE_EQ(update.median_ms, 50);
  EXPECT_DOUBLE_EQ(update.most_of_95_ms, 95);
  EXPECT_DOUBLE_EQ(update.worst_ms, 100);
  EXPECT_EQ(update.worst_frame, 1000);
  EXPECT_NEAR(statistics.stages[1].mean_ms, 100.0 * 51 / 101, 1e-9) << "0 where it was left out";
  EXPECT_DOUBLE_EQ(statistics.all.worst_ms, 200);
}

TEST(TimingStatistics, ListTheSlowestFramesFirst) {
  const TimingStatistics statistics = StatisticsOf(HistoryOf(101), 3);
  ASSERT_EQ(statistics.slowest.size(), 3u);
  EXPECT_EQ(statistics.slowest[0].frame, 1000);
  EXPECT_EQ(statistics.slowest[1].frame, 980);
  EXPECT_DOUBLE_EQ(statistics.slowest[0].total_ms, 200);
  EXPECT_EQ(statistics.slowest[1].stage, "birth");
}

TEST(TimingStatistics, LeaveOutWhatWasNotReadYet) {
  RunHistory history = HistoryOf(3);
  history.frames.push_back(nullptr);
  EXPECT_EQ(StatisticsOf(history).frames, 3);
  EXPECT_EQ(StatisticsOf(RunHistory()).frames, 0);
}

}  // namespace
}  // namespace plumbline
