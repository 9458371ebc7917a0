// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/looks.h"

#include <algorithm>

#include "engine/mapping/novelty_clock.h"

namespace plumbline {
namespace {

constexpr double kLeastNovelty = 0.8;

}  // namespace

std::vector<Look> ChooseLooks(std::span<const PassedFrame> frames, const MapperOptions& options) {
  std::vector<Look> looks;
  NoveltyClock clock;
  double gained = 0;
  std::int64_t last_ns = frames.empty() ? 0 : frames.front().stamp_ns;
  for (const PassedFrame& frame : frames) {
    gained += clock.Advance(frame.stamp_ns, frame.world_from_cam, options);
    if (gained < kLeastNovelty) continue;
    looks.push_back({frame, std::min(1.0, gained),
                     static_cast<double>(frame.stamp_ns - last_ns) * 1e-9});
    last_ns = frame.stamp_ns;
    gained = 0;
  }
  return looks;
}

}  // namespace plumbline
