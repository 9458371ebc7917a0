// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/shown_truths.h"

#include <nlohmann/json.hpp>

#include "engine/analysis/missed_truths.h"

namespace plumbline {
namespace {

void Count(double value, bool found, std::vector<ShownBin>& bins) {
  ShownBin* at = &bins.front();
  for (ShownBin& bin : bins) {
    if (value >= bin.from) at = &bin;
  }
  ++at->truths;
  at->found += found;
}

nlohmann::json BinsToJson(const std::vector<ShownBin>& bins) {
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t i = 0; i < bins.size(); ++i) {
    list.push_back({{"from", bins[i].from},
                    {"below", i + 1 < bins.size() ? nlohmann::json(bins[i + 1].from) : nullptr},
                    {"truths", bins[i].truths},
                    {"found", bins[i].found}});
  }
  return list;
}

}  // namespace

ShownTruths ShownTruthsOf(const TruthsView& truths) {
  ShownTruths shown;
  shown.by_frames = {{0}, {kFewestFramesSeen}, {30}, {100}, {300}};
  shown.by_pixels = {{0}, {1000}, {4000}, {16000}, {64000}};
  for (const TruthView& truth : truths.truths) {
    Count(truth.frames_seen, truth.found, shown.by_frames);
    Count(truth.best_visible_px, truth.found, shown.by_pixels);
  }
  return shown;
}

nlohmann::json ShownTruthsToJson(const ShownTruths& shown) {
  return {{"by_frames", BinsToJson(shown.by_frames)}, {"by_pixels", BinsToJson(shown.by_pixels)}};
}

}  // namespace plumbline
