// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/region_proposals.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

namespace plumbline {
namespace {

using testing::ElementsAre;

/// A level of 4x4 cells of 16 px, one feature and one anchor of 32 px, that sees nothing.
class Level {
 public:
  Level() {
    const int shape[] = {1, 6, 4, 4};
    tensor_.create(4, shape, CV_32FC1);
    tensor_.setTo(0);
    for (int i = 0; i < 16; ++i) tensor_.ptr<float>(0, 1)[i] = -10;
    settings_.anchors = {{{32}, {1}}};
    settings_.proposal_min_score = 0.1f;
  }
  void Put(int row, int column, float objectness, const std::array<float, 4>& deltas = {}) {
    const int cell = row * 4 + column;
    tensor_.ptr<float>(0, 1)[cell] = objectness;
    for (int i = 0; i < 4; ++i) tensor_.ptr<float>(0, 2 + i)[cell] = deltas[i];
  }
  std::vector<RegionProposal> Propose(const cv::Size2f& image = {64, 64}) const {
    const ProposalLevel level{tensor_, 1, 16};
    return ProposeRegions({&level, 1}, settings_, image);
  }
  TwoStageSettings settings_;

 private:
  cv::Mat tensor_;
};

TEST(AnchorsOfCell, GoRatioByRatioAndAreRoundedToEvenHalfSides) {
  const auto anchors = AnchorsOfCell({{32, 64}, {0.5f, 1}});
  EXPECT_THAT(anchors, ElementsAre(Box2{-23, -11, 23, 11}, Box2{-45, -23, 45, 23},
                                   Box2{-16, -16, 16, 16}, Box2{-32, -32, 32, 32}));
  EXPECT_EQ(AnchorsOfCell({{5}, {1}})[0].x1, 2);  // 2.5
}

TEST(MovedBox, ShiftsBySharesAndGrowsByFactors) {
  const Box2 moved = MovedBox({10, 20, 30, 60}, {5, -5, 5 * std::log(2.0f), 0}, {10, 10, 5, 5});
  EXPECT_NEAR(moved.x0, 20 + 10 - 20, 1e-4);
  EXPECT_NEAR(moved.x1, 20 + 10 + 20, 1e-4);
  EXPECT_NEAR(moved.y0, 40 - 20 - 20, 1e-4);
  EXPECT_NEAR(moved.y1, 40 - 20 + 20, 1e-4);
  EXPECT_NEAR(MovedBox({0, 0, 1, 1}, {0, 0, 100, 0}, {1, 1, 1, 1}).width(), 62.5f, 1e-3);
}

TEST(ProposeRegions, PlacesAnchorsAtTheCornersOfTheirCellsAndClipsThem) {
  Level level;
  level.Put(1, 2, 2);
  level.Put(3, 0, 1);
  const auto proposals = level.Propose({64, 50});
  ASSERT_EQ(proposals.size(), 2u);
  EXPECT_EQ(proposals[0].box, (Box2{16, 0, 48, 32}));
  EXPECT_NEAR(proposals[0].score, 1 / (1 + std::exp(-2.0)), 1e-6);
  EXPECT_EQ(proposals[1].box, (Box2{0, 32, 16, 50}));
}

TEST(ProposeRegions, KeepsTheBestOfThoseThatOverlapAndNoMoreThanWanted) {
  Level level;
  level.Put(1, 1, 2);
  level.Put(1, 2, 3, {-0.45f, 0, 0, 0});  // all but on the first
  level.Put(3, 3, 1);
  level.Put(2, 2, 0);
  EXPECT_EQ(level.Propose().size(), 3u);
  level.settings_.proposals_after_nms = 2;
  ASSERT_EQ(level.Propose().size(), 2u);
  EXPECT_NEAR(level.Propose()[0].score, 1 / (1 + std::exp(-3.0)), 1e-6);
  EXPECT_NEAR(level.Propose()[1].score, 1 / (1 + std::exp(-1.0)), 1e-6);
  level.settings_.proposals_before_nms = 1;
  EXPECT_EQ(level.Propose().size(), 1u);
}

TEST(ProposeRegions, DropsSmallWeakAndSenselessBoxes) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Level level;
  level.Put(0, 0, 2, {0, 0, -20, 0});
  level.Put(1, 1, -3);
  level.Put(2, 2, kNan);
  level.Put(3, 3, 2, {kNan, 0, 0, 0});
  level.Put(0, 3, 2, {0, 0, kNan, 0});
  EXPECT_TRUE(level.Propose().empty());
}

}  // namespace
}  // namespace plumbline
