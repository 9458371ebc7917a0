// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/comparison_process.h"

#include <chrono>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/snapshot/map_snapshot.h"
#include "tests/support/fake_source.h"

namespace plumbline {
namespace {

bool Eventually(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

class ComparisonProcessTest : public testing::Test {
 protected:
  ComparedRun Run(int frame, double alpha) const {
    PlaybackView playback;
    playback.history = std::make_shared<const RunHistory>(source_->history());
    RunHeader header;
    header.recipe.options.alpha = alpha;
    return {source_->Past(frame, {}).value(), std::make_shared<const PlaybackView>(playback),
            std::make_shared<const RunHeader>(header)};
  }

  std::unique_ptr<SnapshotSource> source_ = MakeFakeSource(
      {.num_frames = 30, .width = 64, .height = 36, .particles = 5, .recorded = true});
};

TEST_F(ComparisonProcessTest, PairsTheObjectsAndTellsTheSettingsApart) {
  int published = 0;
  ComparisonProcess process([&] { ++published; });
  EXPECT_EQ(process.View(), nullptr);
  const ComparedRun first = Run(29, 2.5), other = Run(28, 4);
  process.Post({first, other});
  ASSERT_TRUE(Eventually([&] { return process.View() != nullptr; }));
  const auto view = process.View();
  EXPECT_EQ(view->a, first.snapshot);
  EXPECT_EQ(view->b, other.snapshot);
  ASSERT_FALSE(view->pairs.empty());
  for (const ObjectPair& pair : view->pairs) {
    ASSERT_NE(pair.a, nullptr);
    ASSERT_NE(pair.b, nullptr);
    EXPECT_EQ(pair.a->id, pair.b->id);
  }
  EXPECT_THAT(view->settings, testing::ElementsAre("alpha: 2.5 / 4.0"));
  EXPECT_FALSE(view->first_difference.has_value()) << "it is the same run";
  EXPECT_FALSE(view->stages.empty());
}

TEST_F(ComparisonProcessTest, TakesTheNewestAndStopsAtOnce) {
  const ComparedRun first = Run(20, 1), last = Run(25, 1);
  {
    ComparisonProcess process({});
    for (int i = 0; i < 50; ++i) process.Post({first, first});
    process.Post({first, last});
    EXPECT_TRUE(Eventually([&] {
      const auto view = process.View();
      return view != nullptr && view->b == last.snapshot;
    }));
    process.Post({last, first});
  }
  SUCCEED() << "the destructor has joined";
}

}  // namespace
}  // namespace plumbline
