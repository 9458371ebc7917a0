// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/roi_align.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

/// Channel 0 is 2 + 3 column - row, channel 1 is 1 everywhere.
FeatureMap Ramp(int rows, int columns, int stride) {
  FeatureMap map{rows, columns, 2, stride, {}};
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      map.values.push_back(2 + 3 * static_cast<float>(column) - static_cast<float>(row));
      map.values.push_back(1);
    }
  }
  return map;
}

float At(const cv::Mat& crops, int box, int channel, int row, int column) {
  const int index[] = {box, channel, row, column};
  return crops.at<float>(index);
}

// Bilinear samples of a ramp lie on it, and their mean is its value at the middle of the bin.
TEST(CropRegions, OfARampIsItsValueInTheMiddleOfEachBin) {
  const std::vector<FeatureMap> maps = {Ramp(20, 30, 8)};
  const Box2 box{13, 22, 150.5f, 99};
  for (const int sampling : {0, 1, 2, 3}) {
    TwoStageSettings settings;
    settings.crop_sampling = sampling;
    const cv::Mat crops = CropRegions(maps, {&box, 1}, 1, settings);
    for (int row = 0; row < 7; ++row) {
      for (int column = 0; column < 7; ++column) {
        const double x = (box.x0 + (column + 0.5) * box.width() / 7) / 8;
        const double y = (box.y0 + (row + 0.5) * box.height() / 7) / 8;
        EXPECT_NEAR(At(crops, 0, 0, row, column), 2 + 3 * x - y, 1e-4);
        EXPECT_NEAR(At(crops, 0, 1, row, column), 1, 1e-6);
      }
    }
  }
}

TEST(CropRegions, AreAtLeastACellAcross) {
  const std::vector<FeatureMap> maps = {Ramp(20, 30, 8)};
  const Box2 box{80, 40, 81, 41};  // a cell of 8 px from its corner
  const cv::Mat crops = CropRegions(maps, {&box, 1}, 1, {});
  EXPECT_NEAR(At(crops, 0, 0, 3, 3), 2 + 3 * 10.5 - 5.5, 1e-4);
}

// The last value holds on for a cell, then there are zeros.
TEST(CropRegions, EndAtTheEdgeOfTheMap) {
  const std::vector<FeatureMap> maps = {Ramp(8, 8, 8)};
  TwoStageSettings settings;
  settings.crop_size = 4;
  settings.crop_sampling = 1;
  const Box2 box{-20, 16, 76, 40};  // samples at the columns -1, 2, 5, 8; the first row is 2.375
  const cv::Mat crops = CropRegions(maps, {&box, 1}, 3, settings);
  EXPECT_NEAR(At(crops, 0, 0, 0, 0), 2 - 2.375, 1e-5);
  EXPECT_NEAR(At(crops, 0, 0, 0, 2), 2 + 3 * 5 - 2.375, 1e-5);
  EXPECT_NEAR(At(crops, 0, 0, 0, 3), 2 + 3 * 7 - 2.375, 1e-5);
  const Box2 beyond{40, 0, 136, 32};  // samples at the columns 6.5, 9.5, 12.5, 15.5
  const cv::Mat outside = CropRegions(maps, {&beyond, 1}, 1, settings);
  EXPECT_NEAR(At(outside, 0, 1, 0, 0), 1, 1e-6);
  EXPECT_EQ(At(outside, 0, 1, 0, 1), 0);
  // What is filled up is zero.
  EXPECT_EQ(crops.size[0], 3);
  EXPECT_EQ(At(crops, 2, 1, 1, 1), 0);
}

TEST(CropLevel, RisesWithTheSizeOfTheBox) {
  const std::vector<FeatureMap> maps = {Ramp(2, 2, 4), Ramp(2, 2, 8), Ramp(2, 2, 16),
                                        Ramp(2, 2, 32)};
  const auto level = [&](float side) { return CropLevel({0, 0, side, side}, maps, {}); };
  EXPECT_EQ(level(1), 0);
  EXPECT_EQ(level(111), 0);
  EXPECT_EQ(level(112), 1);
  EXPECT_EQ(level(224), 2);
  EXPECT_EQ(level(447), 2);
  EXPECT_EQ(level(448), 3);
  EXPECT_EQ(level(5000), 3);
}

TEST(MakeFeatureMap, PutsTheChannelsOfACellSideBySide) {
  const int shape[] = {1, 3, 2, 2};
  cv::Mat tensor(4, shape, CV_32FC1);
  for (int i = 0; i < 12; ++i) tensor.ptr<float>()[i] = static_cast<float>(i);
  const FeatureMap map = MakeFeatureMap(tensor, 1, 2, 16);
  EXPECT_EQ(map.values, (std::vector<float>{4, 8, 5, 9, 6, 10, 7, 11}));
}

}  // namespace
}  // namespace plumbline
