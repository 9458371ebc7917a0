// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/thinning.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "engine/geometry/angles.h"
#include "tests/engine/vision/edge_images.h"

namespace plumbline {
namespace {

TEST(ThinRidges, FindsTheNormalOfARidgeAtEveryAngleAndThinsItToOnePixel) {
  for (int degrees = 0; degrees < 180; degrees += 3) {
    const StraightEdge line{degrees * kRadPerDeg, 0.3};
    cv::Mat soft(line.side_px, line.side_px, CV_32FC1);
    for (int y = 0; y < soft.rows; ++y) {
      for (int x = 0; x < soft.cols; ++x) {
        const double distance = line.Distance(x, y);
        soft.at<float>(y, x) =
            static_cast<float>(0.9 * std::exp(-distance * distance / (2 * 1.5 * 1.5)));
      }
    }
    const EdgeMap edges = ThinRidges(soft, 0.1f, CalibrationCurve({}));
    const LineQuality quality = MeasureLine(edges, line);
    EXPECT_LT(quality.worst_angle_deg, 1.5) << degrees;
    EXPECT_NEAR(quality.pixels_per_step, 1, 0.03) << degrees;
    EXPECT_NEAR(quality.mean_offset_px, 0, 0.31)
        << degrees;  // the nearest row of pixels is 0.3 off at 45 degrees
    EXPECT_EQ(quality.strays, 0) << degrees;
  }
}

TEST(ThinRidges, KeepsOneLineOfAPlateau) {
  cv::Mat soft = cv::Mat::zeros(60, 60, CV_32FC1);
  soft.colRange(28, 32) = 1.0f;  // four pixels wide, all certain
  const EdgeMap edges = ThinRidges(soft, 0.1f, CalibrationCurve({}));
  for (int y = 10; y < 50; ++y) EXPECT_EQ(cv::countNonZero(edges.probability.row(y)), 1) << y;
}

TEST(ThinRidges, FindsNothingInNothing) {
  const EdgeMap edges = ThinRidges(cv::Mat::zeros(40, 50, CV_32FC1), 0.1f, CalibrationCurve({}));
  EXPECT_EQ(cv::countNonZero(edges.probability), 0);
  EXPECT_EQ(edges.angle.size(), cv::Size(50, 40));
}

TEST(ThinRidges, TakesTinyImages) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 5), cv::Size(3, 3)}) {
    EXPECT_EQ(
        ThinRidges(cv::Mat::ones(size, CV_32FC1), 0.1f, CalibrationCurve({})).probability.size(),
        size);
  }
}

TEST(RemoveSpareCorners, TurnsStaircasesIntoLinesAndKeepsThemWhole) {
  cv::Mat map = cv::Mat::zeros(20, 20, CV_8UC1);
  cv::Mat strength = cv::Mat::ones(20, 20, CV_32FC1);
  for (int i = 2; i < 17; ++i) {
    map.at<unsigned char>(i, i) = map.at<unsigned char>(i, i + 1) = 7;
    strength.at<float>(i, i) = 2;
  }
  RemoveSpareCorners(strength, map);
  for (int i = 2; i < 17; ++i)
    EXPECT_NE(map.at<unsigned char>(i, i), 0) << i;  // the stronger ones stay
  cv::Mat labels;
  EXPECT_EQ(cv::connectedComponents(map, labels, 8), 2);  // one, and the background
  EXPECT_LE(cv::countNonZero(map), 17);
  EXPECT_GE(cv::countNonZero(map), 15);
}

TEST(RemoveSpareCorners, LeavesThinLinesAndSinglePixels) {
  cv::Mat map = cv::Mat::zeros(30, 30, CV_8UC1);
  map.row(5).colRange(3, 20) = 1;
  map.at<unsigned char>(10, 10) = map.at<unsigned char>(10, 11) = 1;
  map.at<unsigned char>(20, 20) = 1;
  for (int i = 12; i < 18; ++i) map.at<unsigned char>(i, i) = 1;
  const cv::Mat before = map.clone();
  RemoveSpareCorners(cv::Mat::ones(30, 30, CV_32FC1), map);
  EXPECT_EQ(cv::norm(map, before, cv::NORM_INF), 0);
}

TEST(CalibrationCurve, IsLinearBetweenItsPointsAndConstantBeyond) {
  const CalibrationCurve curve({{0.2f, 0.1f}, {0.6f, 0.5f}, {0.8f, 0.9f}});
  EXPECT_FLOAT_EQ(curve(0), 0.1f);
  EXPECT_FLOAT_EQ(curve(0.4f), 0.3f);
  EXPECT_FLOAT_EQ(curve(0.7f), 0.7f);
  EXPECT_FLOAT_EQ(curve(1), 0.9f);
  EXPECT_FLOAT_EQ(CalibrationCurve({})(0.3f), 0.3f);
}

TEST(AngleToByte, WrapsAtPi) {
  EXPECT_EQ(AngleToByte(0), 0);
  EXPECT_EQ(AngleToByte(static_cast<float>(std::numbers::pi / 2)), 128);
  EXPECT_EQ(AngleToByte(static_cast<float>(-std::numbers::pi / 2)), 128);
  EXPECT_EQ(AngleToByte(static_cast<float>(std::numbers::pi - 1e-4)), 0);
}

}  // namespace
}  // namespace plumbline
