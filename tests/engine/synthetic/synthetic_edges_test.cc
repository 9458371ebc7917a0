// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/synthetic_edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <opencv2/imgproc.hpp>

namespace plumbline {
namespace {

constexpr EdgeFlaws kNoFlaws{0, 0, 0};

/// A turned, bright square at 1 m before a dark wall at 3 m; both face the camera.
class TurnedSquare : public testing::Test {
 protected:
  void SetUp() override {
    const cv::Size size(camera_.width, camera_.height);
    maps_.depth = cv::Mat(size, CV_32F, cv::Scalar(3));
    maps_.instance = cv::Mat(size, CV_16U, cv::Scalar(0));
    maps_.surface = cv::Mat(size, CV_32S, cv::Scalar(0));
    maps_.normal = cv::Mat(size, CV_32FC3, cv::Scalar(0, 0, -1));
    picture_ = cv::Mat(size, CV_32FC3, cv::Scalar::all(0.3));
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const cv::Point2d p = InSquare(x, y);
        if (std::max(std::abs(p.x), std::abs(p.y)) > kHalf) continue;
        maps_.depth.at<float>(y, x) = 1;
        maps_.instance.at<std::uint16_t>(y, x) = 1;
        picture_.at<cv::Vec3f>(y, x) = {0.8f, 0.8f, 0.8f};
      }
    }
  }
  cv::Point2d InSquare(double x, double y) const {
    const double dx = x - 160, dy = y - 100;
    return {std::cos(kTurn) * dx + std::sin(kTurn) * dy,
            -std::sin(kTurn) * dx + std::cos(kTurn) * dy};
  }

  static constexpr double kHalf = 60, kTurn = 0.4;
  PinholeCamera camera_{320, 200, 300, 300, 160, 100};
  SurfaceMaps maps_;
  cv::Mat picture_;
};

TEST_F(TurnedSquare, HasOnePixelLinesOnTheNearSideOfItsBorder) {
  const EdgeMap edges = DetectSyntheticEdges(camera_, maps_, picture_, kNoFlaws, 1, 0);
  int count = 0;
  for (int y = 1; y < edges.probability.rows; ++y) {
    for (int x = 1; x < edges.probability.cols; ++x) {
      if (edges.probability.at<std::uint8_t>(y, x) == 0) continue;
      ++count;
      const cv::Point2d p = InSquare(x, y);
      const double inside = kHalf - std::max(std::abs(p.x), std::abs(p.y));
      EXPECT_GE(inside, -1e-6);
      EXPECT_LT(inside, 1.5);
      EXPECT_FALSE(edges.probability.at<std::uint8_t>(y - 1, x) &&
                   edges.probability.at<std::uint8_t>(y, x - 1) &&
                   edges.probability.at<std::uint8_t>(y - 1, x - 1))
          << "a filled block at " << x << ", " << y;
    }
  }
  const double length = 8 * kHalf;
  EXPECT_GT(count, 0.65 * length);  // a diagonal line has fewer pixels than its length
  EXPECT_LT(count, 1.1 * length);
}

TEST_F(TurnedSquare, HasTheAngleOfItsNormals) {
  const EdgeMap edges = DetectSyntheticEdges(camera_, maps_, picture_, kNoFlaws, 1, 0);
  double worst = 0, sum = 0;
  int count = 0;
  for (int y = 0; y < edges.probability.rows; ++y) {
    for (int x = 0; x < edges.probability.cols; ++x) {
      if (edges.probability.at<std::uint8_t>(y, x) == 0) continue;
      const cv::Point2d p = InSquare(x, y);
      if (std::abs(std::abs(p.x) - std::abs(p.y)) < 10) continue;  // corners
      const double normal = std::abs(p.x) > std::abs(p.y) ? kTurn : kTurn + std::numbers::pi / 2;
      const double angle = edges.angle.at<std::uint8_t>(y, x) * std::numbers::pi / 256;
      const double error = std::abs(std::remainder(angle - normal, std::numbers::pi));
      worst = std::max(worst, error);
      sum += error;
      ++count;
    }
  }
  ASSERT_GT(count, 200);
  EXPECT_LT(sum / count, 0.06);  // a tenth of a pixel over the window: the staircase of the grid
  EXPECT_LT(worst, 0.25);
}

TEST_F(TurnedSquare, LosesATenthOfItsPixelsAndGainsAFewFalseOnes) {
  const EdgeMap clean = DetectSyntheticEdges(camera_, maps_, picture_, kNoFlaws, 1, 0);
  double kept = 0, off_line = 0, displaced = 0;
  const int wanted = cv::countNonZero(clean.probability);
  cv::Mat far;
  cv::distanceTransform(clean.probability == 0, far, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  constexpr int kFewFrames = 30;
  for (int frame = 0; frame < kFewFrames; ++frame) {
    const EdgeMap edges = DetectSyntheticEdges(
        camera_, maps_, picture_, {.dropped = 0.1, .jitter_px = 0, .spurious = 0}, 1, frame);
    kept += cv::countNonZero(edges.probability) / static_cast<double>(wanted) / kFewFrames;
    const EdgeMap flawed = DetectSyntheticEdges(camera_, maps_, picture_, {}, 1, frame);
    for (int y = 0; y < far.rows; ++y) {
      for (int x = 0; x < far.cols; ++x) {
        if (flawed.probability.at<std::uint8_t>(y, x) == 0) continue;
        if (far.at<float>(y, x) > 2.5f)
          off_line += 1.0 / wanted / kFewFrames;
        else
          displaced += far.at<float>(y, x) > 0.9f;
      }
    }
  }
  EXPECT_NEAR(kept, 0.9, 0.01);
  EXPECT_GT(off_line, 0.01);
  EXPECT_LT(off_line, 0.06);
  EXPECT_GT(displaced, 0) << "jitter moves some pixels off the line";
}

TEST_F(TurnedSquare, IsProbableByItsContrast) {
  cv::Mat faint = picture_.clone();
  faint = 0.3 + 0.05 * (picture_ - 0.3);
  const EdgeMap strong = DetectSyntheticEdges(camera_, maps_, picture_, kNoFlaws, 1, 0);
  const EdgeMap weak = DetectSyntheticEdges(camera_, maps_, faint, kNoFlaws, 1, 0);
  EXPECT_GT(cv::mean(strong.probability, strong.probability > 0)[0], 240);
  EXPECT_LT(cv::mean(weak.probability, weak.probability > 0)[0], 160);
}

TEST_F(TurnedSquare, SeesTextureWithoutADepthStep) {
  maps_.depth.setTo(3);
  const EdgeMap edges = DetectSyntheticEdges(camera_, maps_, picture_, kNoFlaws, 1, 0);
  EXPECT_GT(cv::countNonZero(edges.probability), 300);
  maps_.depth.setTo(3);
  picture_.setTo(cv::Scalar::all(0.3));
  EXPECT_EQ(
      cv::countNonZero(DetectSyntheticEdges(camera_, maps_, picture_, kNoFlaws, 1, 0).probability),
      0);
}

TEST_F(TurnedSquare, SlopingPlanesHaveNoEdgesInside) {
  // A floor 1.4 m below the camera, seen to 20 m: depth changes by more than a metre from row to
  // row far away.
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 0; x < camera_.width; ++x) {
      const double down = (y - camera_.cy) / camera_.fy;
      const bool floor = down > 0.07;
      maps_.depth.at<float>(y, x) = floor ? static_cast<float>(1.4 / down) : 20;
      maps_.normal.at<cv::Vec3f>(y, x) = floor ? cv::Vec3f(0, -1, 0) : cv::Vec3f(0, 0, -1);
    }
  }
  const cv::Mat edges = GeometricEdges(camera_, maps_);
  const int horizon = static_cast<int>(camera_.cy + 0.07 * camera_.fy);
  EXPECT_EQ(cv::countNonZero(edges.rowRange(horizon + 3, camera_.height)), 0);
  EXPECT_GT(cv::countNonZero(edges.rowRange(horizon - 2, horizon + 3)), camera_.width / 2);
}

}  // namespace
}  // namespace plumbline
