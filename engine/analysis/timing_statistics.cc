// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/timing_statistics.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <string_view>

namespace plumbline {
namespace {

/// @param ms  Of every frame.
StageStatistics StatisticsOfStage(const std::string& stage, std::vector<double> ms,
                                  const std::vector<int>& frames) {
  StageStatistics of{stage};
  const auto count = static_cast<double>(ms.size());
  of.mean_ms = std::accumulate(ms.begin(), ms.end(), 0.0) / count;
  const auto worst = std::max_element(ms.begin(), ms.end());
  of.worst_ms = *worst;
  of.worst_frame = frames[static_cast<std::size_t>(worst - ms.begin())];
  const auto below = [&](double share) {
    const auto at = ms.begin() + static_cast<std::ptrdiff_t>(share * (count - 1));
    std::nth_element(ms.begin(), at, ms.end());
    return *at;
  };
  of.median_ms = below(0.5);
  of.most_of_95_ms = below(0.95);
  return of;
}

}  // namespace

TimingStatistics StatisticsOf(const RunHistory& history, int most_slow) {
  TimingStatistics statistics;
  std::vector<int> frames;
  std::vector<double> totals;
  std::vector<std::string> names;
  std::map<std::string_view, std::vector<double>> by_stage;
  for (const auto& sample : history.frames) {
    if (sample == nullptr || sample->timings.empty()) continue;
    TimingStatistics::SlowFrame slow{sample->frame};
    frames.push_back(sample->frame);
    for (const StageTiming& timing : sample->timings) {
      auto [of, is_new] = by_stage.try_emplace(timing.stage);
      if (is_new) names.push_back(timing.stage);
      of->second.resize(frames.size());  // 0 ms where it was left out
      of->second.back() += timing.milliseconds;
      slow.total_ms += timing.milliseconds;
      if (timing.milliseconds <= slow.stage_ms) continue;
      slow.stage = timing.stage;
      slow.stage_ms = timing.milliseconds;
    }
    totals.push_back(slow.total_ms);
    statistics.slowest.push_back(std::move(slow));
  }
  statistics.frames = static_cast<int>(frames.size());
  if (frames.empty()) return statistics;
  for (const std::string& name : names) {
    by_stage[name].resize(frames.size());
    statistics.stages.push_back(StatisticsOfStage(name, std::move(by_stage[name]), frames));
  }
  statistics.all = StatisticsOfStage("all", std::move(totals), frames);
  const auto listed = statistics.slowest.begin() +
                      std::min<std::ptrdiff_t>(most_slow, std::ssize(statistics.slowest));
  std::partial_sort(statistics.slowest.begin(), listed, statistics.slowest.end(),
                    [](const auto& a, const auto& b) { return a.total_ms > b.total_ms; });
  statistics.slowest.erase(listed, statistics.slowest.end());
  return statistics;
}

}  // namespace plumbline
