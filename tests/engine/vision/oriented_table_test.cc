// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/oriented_table.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "engine/vision/thinning.h"

namespace plumbline {
namespace {

constexpr int kSide = 120;

EdgeMap NoEdges() {
  return {cv::Mat::zeros(kSide, kSide, CV_8UC1), cv::Mat::zeros(kSide, kSide, CV_8UC1)};
}

/// A thin line through (59.5, 59.5): one pixel for every step along its major axis.
EdgeMap LineWithNormal(double normal_rad, int probability = 255) {
  EdgeMap edges = NoEdges();
  const double nx = std::cos(normal_rad), ny = std::sin(normal_rad);
  const bool mostly_vertical = std::abs(nx) >= std::abs(ny);
  for (int i = 0; i < kSide; ++i) {
    const double along = i - 59.5;
    const int j =
        static_cast<int>(std::lround(59.5 - along * (mostly_vertical ? ny / nx : nx / ny)));
    if (j < 0 || j >= kSide) continue;
    const int x = mostly_vertical ? j : i, y = mostly_vertical ? i : j;
    edges.probability.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(probability);
    edges.angle.at<std::uint8_t>(y, x) = AngleToByte(static_cast<float>(normal_rad));
  }
  return edges;
}

int BinOf(double angle_rad) {
  return static_cast<int>(angle_rad / std::numbers::pi * OrientedTable::kBins) %
         OrientedTable::kBins;
}

TEST(OrientedTable, HitFallsWithDistanceFromTheEdge) {
  OrientedTableOptions options;
  options.power = 1;
  EdgeMap edges = NoEdges();
  edges.probability.col(60) = 200;  // normal along x
  const OrientedTable table(edges, options);
  for (int k = -15; k <= 15; ++k) {
    // The bin's normal is 5.6 degrees off the edge's: the way to the edge is k / cos of that.
    const double way = k / std::cos(0.5 * std::numbers::pi / OrientedTable::kBins);
    const double expected =
        std::abs(way) <= options.radius_px
            ? 200 * std::exp(-way * way / (2 * options.sigma_px * options.sigma_px))
            : 0;
    EXPECT_NEAR(table.Hit(60 + k, 50, 0), expected, 1.5) << k;
    EXPECT_EQ(table.Hit(60 + k, 50, 0), table.Hit(60 + k, 50, OrientedTable::kBins - 1)) << k;
  }
}

TEST(OrientedTable, CountsOnlyEdgesWhoseNormalAgrees) {
  const OrientedTableOptions options;
  for (int degrees = 0; degrees < 180; degrees += 7) {
    const double normal = degrees * std::numbers::pi / 180;
    const OrientedTable table(LineWithNormal(normal), options);
    for (int bin = 0; bin < OrientedTable::kBins; ++bin) {
      const double center = (bin + 0.5) * std::numbers::pi / OrientedTable::kBins;
      const double agreement = std::abs(std::cos(center - normal));
      if (std::abs(agreement - options.min_agreement) < 0.01) continue;  // angles come as bytes
      int highest = 0;
      for (int y = 40; y < 80; ++y) {
        for (int x = 40; x < 80; ++x) highest = std::max<int>(highest, table.Hit(x, y, bin));
      }
      if (agreement > options.min_agreement) {
        EXPECT_GE(highest, 250) << degrees << " deg, bin " << bin;
      } else {
        EXPECT_EQ(highest, 0) << degrees << " deg, bin " << bin;
      }
    }
  }
}

TEST(OrientedTable, LeavesNoHolesWhateverTheDirection) {
  const OrientedTableOptions options;
  for (int degrees = 0; degrees < 180; degrees += 3) {
    const double normal = degrees * std::numbers::pi / 180;
    const OrientedTable table(LineWithNormal(normal), options);
    const int bin = BinOf(normal);
    for (int y = 45; y < 75; ++y) {
      for (int x = 45; x < 75; ++x) {
        const double away = (x - 59.5) * std::cos(normal) + (y - 59.5) * std::sin(normal);
        if (std::abs(away) > options.radius_px - 2) continue;
        // The nearest pixel of the line is up to a pixel nearer or further than the line.
        const auto weight = [&](double k) {
          return 255 * std::exp(-k * k / (2 * options.sigma_px * options.sigma_px));
        };
        EXPECT_GE(table.Hit(x, y, bin), weight(std::abs(away) + 1.3) - 2)
            << degrees << " deg at " << x << ", " << y;
        EXPECT_LE(table.Hit(x, y, bin), weight(std::max(0.0, std::abs(away) - 1.3)) + 2)
            << degrees << " deg at " << x << ", " << y;
      }
    }
  }
}

TEST(OrientedTable, ChanceIsTheMeanOfAllHits) {
  const OrientedTable table(LineWithNormal(0.4), {});
  double sum = 0;
  for (const std::uint8_t hit : table.Interleaved()) sum += hit;
  EXPECT_GT(table.chance(), 0.01);
  EXPECT_NEAR(table.chance(), sum / (255.0 * kSide * kSide * OrientedTable::kBins), 1e-12);
  EXPECT_EQ(OrientedTable(NoEdges(), {}).chance(), 0);
}

TEST(OrientedTable, WeakerEdgesCountLess) {
  const int bin = BinOf(1.0);
  for (const double power : {1.0, 2.0, 3.0}) {
    OrientedTableOptions options;
    options.power = power;
    const OrientedTable strong(LineWithNormal(1.0, 250), options);
    const OrientedTable weak(LineWithNormal(1.0, 100), options);
    for (int x = 50; x < 70; ++x) {
      EXPECT_NEAR(weak.Hit(x, 60, bin), std::pow(0.4, power) * strong.Hit(x, 60, bin), 1.5)
          << x << ", power " << power;
    }
  }
}

TEST(OrientedTable, EdgesAtTheBordersOfTheImageCountInside) {
  EdgeMap edges = NoEdges();
  edges.probability.col(0) = 255;
  edges.probability.col(kSide - 1) = 255;
  edges.probability.row(0) = 255;
  edges.angle.row(0) = 128;
  edges.probability.row(kSide - 1) = 255;
  edges.angle.row(kSide - 1) = 128;
  const OrientedTable table(edges, {});
  EXPECT_GE(table.Hit(2, 60, 0), 200);
  EXPECT_GE(table.Hit(kSide - 3, 60, 0), 200);
  EXPECT_GE(table.Hit(60, 2, OrientedTable::kBins / 2), 200);
  EXPECT_GE(table.Hit(60, kSide - 3, OrientedTable::kBins / 2), 200);
  EXPECT_EQ(table.Hit(60, 60, 0), 0);
}

TEST(HalfSize, IsThatOfTheScaledCameraForOddImagesToo) {
  for (const cv::Size size : {cv::Size(621, 465), cv::Size(1242, 375), cv::Size(5, 4)}) {
    EdgeMap edges;
    edges.probability = cv::Mat::zeros(size, CV_8U);
    edges.angle = cv::Mat::zeros(size, CV_8U);
    edges.probability.at<std::uint8_t>(size.height - 1, size.width - 1) = 200;
    edges.angle.at<std::uint8_t>(size.height - 1, size.width - 1) = 77;
    const PinholeCamera half =
        PinholeCamera{size.width, size.height, 500, 500, 300, 200}.Scaled(0.5);
    const EdgeMap small = HalfSize(edges);
    EXPECT_EQ(small.probability.size(), cv::Size(half.width, half.height));
    EXPECT_EQ(small.probability.at<std::uint8_t>(half.height - 1, half.width - 1), 200);
    EXPECT_EQ(small.angle.at<std::uint8_t>(half.height - 1, half.width - 1), 77);
  }
}

}  // namespace
}  // namespace plumbline
