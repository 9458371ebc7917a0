// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/nearest_edges.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

constexpr int kSize = 64;

/// Contours that are vertical lines: a hypothesis at column `center.x()`, rows 10 to 49, a point in
/// each, of a metre each; the whole contour is `center.y()` times as long.
class VerticalLines : public HypothesisScorer {
 public:
  void Score(const ScoringView& view, const UprightFrame&,
             std::span<const PoseHypothesis> hypotheses,
             std::span<HypothesisScore> scores) const override {
    for (std::size_t i = 0; i < hypotheses.size(); ++i) {
      const int column = static_cast<int>(hypotheses[i].center_in_world.x());
      for (int row = 10; row < 50; ++row) {
        scores[i].agreement_m +=
            static_cast<float>(view.table->Hit(column, row, 0) / 255.0 - view.table->chance());
        scores[i].visible_m += 1;
        scores[i].total_m += static_cast<float>(hypotheses[i].center_in_world.y());
      }
    }
  }
};

/// An edge along a column, with a horizontal normal.
EdgeMap Column(int column, int first_row, int last_row, int level) {
  EdgeMap edges{cv::Mat::zeros(kSize, kSize, CV_8U), cv::Mat::zeros(kSize, kSize, CV_8U)};
  edges.probability(cv::Range(first_row, last_row + 1), cv::Range(column, column + 1)) = level;
  return edges;
}

EdgeMatch MatchAt(int column, const EdgeMap& edges, double whole = 1) {
  PoseHypothesis hypothesis;
  hypothesis.center_in_world = {static_cast<double>(column), whole, 1};
  return NearestEdges(edges, 10, {})
      .Match(VerticalLines(), {}, UprightFrame({0, 0, -1}), {&hypothesis, 1})
      .front();
}

// Distances are steps of 11 px / 255 and measured along the middle of a bin of directions, 5.6
// degrees off: 1 %.
TEST(NearestEdges, GiveTheShareOfMatchedPointsOverTheirMeanDistance) {
  const EdgeMap whole = Column(30, 0, kSize - 1, 255);
  const EdgeMatch three_off = MatchAt(33, whole);
  EXPECT_NEAR(three_off.ratio, 1, 1e-6);
  EXPECT_NEAR(three_off.distance_px, 3, 0.06);
  EXPECT_NEAR(three_off.Score(), 1 / 3.0, 0.01);
  const EdgeMatch six_off = MatchAt(24, whole);
  EXPECT_NEAR(six_off.distance_px, 6, 0.1);

  // Half of the points have none: the ratio halves, the distance stays. Lines are two pixels wide,
  // so that one point more may find an end.
  const EdgeMatch half = MatchAt(33, Column(30, 30, kSize - 1, 255));
  EXPECT_NEAR(half.ratio, 0.5, 1.0 / 40 + 1e-6);
  EXPECT_NEAR(half.distance_px, 3, 0.06);
}

TEST(NearestEdges, TakeTheNearestOfTwo) {
  EdgeMap edges = Column(30, 0, kSize - 1, 255);
  edges.probability.col(41) = 255;
  EXPECT_NEAR(MatchAt(33, edges).distance_px, 3, 0.06);
  EXPECT_NEAR(MatchAt(38, edges).distance_px, 3, 0.06);
}

TEST(NearestEdges, AreNoNearerThanHalfAPixel) {
  const EdgeMatch on = MatchAt(30, Column(30, 0, kSize - 1, 255));
  EXPECT_NEAR(on.distance_px, 0, 1e-4);  // rounding of single precision
  EXPECT_NEAR(on.Score(), 2, 1e-5);
  // One point of forty on an edge is worth a fortieth of that.
  EXPECT_NEAR(MatchAt(30, Column(30, 40, 40, 255)).Score(), 2.0 / 40, 0.05);
}

TEST(NearestEdges, SayNothingOfAContourThatHardlyShows) {
  const EdgeMap whole = Column(30, 0, kSize - 1, 255);
  EXPECT_GT(MatchAt(30, whole, 3.9).Score(), 0);
  EXPECT_EQ(MatchAt(30, whole, 4.1).Score(), 0);
}

TEST(NearestEdges, AreHard) {
  EXPECT_EQ(MatchAt(33, Column(30, 0, kSize - 1, 63)).ratio, 0);
  EXPECT_NEAR(MatchAt(33, Column(30, 0, kSize - 1, 64)).ratio, 1, 1e-6);
  EXPECT_EQ(MatchAt(41, Column(30, 0, kSize - 1, 255)).ratio, 0) << "beyond the search";
  EXPECT_EQ(MatchAt(41, Column(30, 0, kSize - 1, 255)).Score(), 0);
  EdgeMap across = Column(30, 0, kSize - 1, 255);
  across.angle = 128;  // a vertical normal
  EXPECT_EQ(MatchAt(33, across).ratio, 0);
}

TEST(NearestEdges, AtFullSizeAreSearchedAQuarterAsFarAsTold) {
  const EdgeMap whole = Column(30, 0, kSize - 1, 255);
  const std::vector<NearestEdges> levels = SearchLevels(whole, {});
  ASSERT_EQ(levels.size(), 2u);
  const auto distance = [&](const NearestEdges& level, double column) {
    PoseHypothesis hypothesis;
    hypothesis.center_in_world = {column, 1, 1};
    return level.Match(VerticalLines(), {}, UprightFrame({0, 0, -1}), {&hypothesis, 1})[0];
  };
  EXPECT_NEAR(distance(levels[1], 34).distance_px, 4, 0.06);
  EXPECT_EQ(distance(levels[1], 37).ratio, 0) << "5 px at full size";
}

}  // namespace
}  // namespace plumbline
