// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/shown_truths.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace plumbline {
namespace {

TruthView Shown(int frames, float pixels, bool found) {
  TruthView truth;
  truth.frames_seen = frames;
  truth.best_visible_px = pixels;
  truth.found = found;
  return truth;
}

TEST(ShownTruthsOf, CountsEachInstanceInItsBins) {
  TruthsView truths;
  truths.truths = {Shown(0, 0, false), Shown(9, 999, true), Shown(10, 1000, true),
                   Shown(300, 80000, true), Shown(5000, 63999, false)};
  const ShownTruths shown = ShownTruthsOf(truths);
  std::vector<int> frames, found, pixels;
  for (const ShownBin& bin : shown.by_frames) {
    frames.push_back(bin.truths);
    found.push_back(bin.found);
  }
  for (const ShownBin& bin : shown.by_pixels) pixels.push_back(bin.truths);
  EXPECT_EQ(frames, (std::vector<int>{2, 1, 0, 0, 2}));
  EXPECT_EQ(found, (std::vector<int>{1, 1, 0, 0, 1}));
  EXPECT_EQ(pixels, (std::vector<int>{2, 1, 0, 1, 1}));
}

TEST(ShownTruthsOf, GivesTheBoundsOfItsBins) {
  const nlohmann::json json = ShownTruthsToJson(ShownTruthsOf({}));
  EXPECT_EQ(json["by_frames"][1]["from"], 10);
  EXPECT_EQ(json["by_frames"][1]["below"], 30);
  EXPECT_TRUE(json["by_pixels"].back()["below"].is_null());
  EXPECT_EQ(json["by_pixels"][0]["truths"], 0);
}

}  // namespace
}  // namespace plumbline
