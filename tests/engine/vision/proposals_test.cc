// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/proposals.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/base/timer.h"
#include "engine/vision/detector.h"

namespace plumbline {
namespace {

Box2 RandomBox(Random& random) {
  const auto x = static_cast<float>(random.Uniform(0, 600)),
             y = static_cast<float>(random.Uniform(0, 440));
  return {x, y, x + static_cast<float>(random.Uniform(10, 300)),
          y + static_cast<float>(random.Uniform(10, 300))};
}

TEST(SuppressNonMaxima, KeepsTheBestOfEachPlaceAndCategory) {
  const Box2 place{0, 0, 100, 100}, nearby{5, 0, 105, 100}, elsewhere{200, 0, 300, 100};
  const std::vector<Detection> kept = SuppressNonMaxima({{nearby, "chair", 0.5f},
                                                         {place, "chair", 0.9f},
                                                         {nearby, "sofa", 0.4f},
                                                         {elsewhere, "chair", 0.6f}},
                                                        0.45f);
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_EQ(kept[0].score, 0.9f);
  EXPECT_EQ(kept[1].score, 0.6f);
  EXPECT_EQ(kept[2].category, "sofa");
}

TEST(SuppressNonMaxima, DoesNotDependOnTheOrderOfTheInput) {
  Random random({.seed = 1});
  std::vector<Detection> detections;
  for (int i = 0; i < 60; ++i)
    detections.push_back({RandomBox(random), i % 2 ? "a" : "b", 0.1f * static_cast<float>(i % 7)});
  const std::vector<Detection> kept = SuppressNonMaxima(detections, 0.45f);
  std::reverse(detections.begin(), detections.end());
  const std::vector<Detection> again = SuppressNonMaxima(detections, 0.45f);
  ASSERT_EQ(kept.size(), again.size());
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i].box, again[i].box);
}

TEST(ScoredBoxes, ScoreIsTheBestProductOfScoreAndOverlap) {
  Random random({.seed = 2});
  ScoredBoxes scored;
  std::vector<std::pair<Box2, float>> all;
  for (int i = 0; i < 100; ++i) {
    all.emplace_back(RandomBox(random), static_cast<float>(random.Uniform()));
    scored.Add(all.back().first, all.back().second);
  }
  scored.Sort();
  for (int i = 0; i < 200; ++i) {
    const Box2 query = RandomBox(random);
    float expected = 0;
    for (const auto& [box, score] : all) expected = std::max(expected, score * Iou(box, query));
    EXPECT_NEAR(scored.Score(query), expected, 1e-6);
  }
  EXPECT_EQ(scored.Score({}), 0);
  EXPECT_EQ(scored.Score({-900, -900, -800, -800}), 0);
}

TEST(ScoredBoxes, ScoreIsContinuousInTheBox) {
  Random random({.seed = 3});
  ScoredBoxes scored;
  for (int i = 0; i < 100; ++i) scored.Add(RandomBox(random), static_cast<float>(random.Uniform()));
  scored.Sort();
  for (int i = 0; i < 500; ++i) {
    const Box2 query = RandomBox(random);
    const float step = 0.01f;
    const Box2 moved{query.x0 + step, query.y0 - step, query.x1 + step, query.y1 - step};
    // IoU changes by at most about 4 steps over the shorter side, 10 px.
    EXPECT_NEAR(scored.Score(query), scored.Score(moved), 4 * step / 10);
  }
}

TEST(DetectionsFromProposals, SortsAndScoresByCategory) {
  const auto detections =
      DetectionsFromProposals({{{0, 0, 10, 10}, "chair", 0.4f}, {{0, 0, 20, 10}, "cup", 0.8f}});
  EXPECT_EQ(detections->proposals()[0].category, "cup");
  const std::vector<Box2> boxes = {{0, 0, 10, 10}, {0, 0, 10, 5}, {}};
  std::vector<float> scores(3, -1);
  detections->ScoreBoxes("chair", boxes, scores);
  EXPECT_FLOAT_EQ(scores[0], 0.4f);
  EXPECT_FLOAT_EQ(scores[1], 0.2f);
  EXPECT_EQ(scores[2], 0);
  detections->ScoreBoxes("unicorn", boxes, scores);
  EXPECT_EQ(scores[0], 0);
}

TEST(ScoredBoxes, AnswersThreeThousandQuestionsInAboutAMillisecond) {
  Random random({.seed = 4});
  ScoredBoxes scored;
  // As many cells as see a chair on a busy frame of the kitchen, most of them faintly.
  for (int i = 0; i < 120; ++i)
    scored.Add(RandomBox(random), static_cast<float>(0.01 + 0.7 * std::pow(random.Uniform(), 3)));
  scored.Sort();
  std::vector<Box2> boxes;
  for (int i = 0; i < 3000; ++i) boxes.push_back(RandomBox(random));
  Stopwatch watch;
  float sum = 0;
  for (const Box2& box : boxes) sum += scored.Score(box);
  const double elapsed = watch.Milliseconds();
  RecordProperty("milliseconds", std::to_string(elapsed));
  EXPECT_GT(sum, 0);
  EXPECT_LT(elapsed, 10);  // 0.7 ms measured; the rest is room for busy machines
}

}  // namespace
}  // namespace plumbline
