// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/edge_claims.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

constexpr int kWidth = 40, kHeight = 30;

/// An outline that meets the vertical edge at column 20 with `offset` pixels.
ImageCheck Meets(float offset, float strength) {
  ImageCheck check;
  for (int y = 5; y < 25; y += 4) {
    OutlineSample sample;
    sample.pixel = {20 - offset, static_cast<float>(y)};
    sample.normal = {1, 0};
    sample.length_px = 4;
    check.outline.samples.push_back(sample);
    check.hits.push_back({offset, strength});
  }
  return check;
}

EdgeMap VerticalEdge() {
  EdgeMap edges{cv::Mat::zeros(kHeight, kWidth, CV_8U), cv::Mat::zeros(kHeight, kWidth, CV_8U)};
  edges.probability.col(20).setTo(200);
  return edges;
}

TEST(EdgeClaims, AnEdgeIsSharedByThoseWhoExplainIt) {
  const cv::Size image(kWidth, kHeight);
  const auto own = ClaimsOf(Meets(2, 0.6f), image), other = ClaimsOf(Meets(0, 0.3f), image);
  ASSERT_FALSE(own.empty());
  for (std::size_t i = 1; i < own.size(); ++i) EXPECT_LT(own[i - 1].pixel, own[i].pixel);
  const EdgeMap mine = ShareOf(VerticalEdge(), own, std::vector{&other});
  const EdgeMap theirs = ShareOf(VerticalEdge(), other, std::vector{&own});
  const int shares =
      mine.probability.at<std::uint8_t>(13, 20) + theirs.probability.at<std::uint8_t>(13, 20);
  EXPECT_GT(mine.probability.at<std::uint8_t>(13, 20), 120) << "the better explanation";
  EXPECT_NEAR(shares, 200, 0.1 * 200) << "claimed once, up to what nobody may have drawn";
}

TEST(EdgeClaims, WhatNobodyClaimsIsLeftToEveryone) {
  const cv::Size image(kWidth, kHeight);
  const auto other = ClaimsOf(Meets(0, 0.8f), image);
  const EdgeMap left = ShareOf(VerticalEdge(), {}, std::vector{&other});
  EXPECT_EQ(left.probability.at<std::uint8_t>(28, 20), 200);
  EXPECT_LT(left.probability.at<std::uint8_t>(13, 20), 20);
}

}  // namespace
}  // namespace plumbline
