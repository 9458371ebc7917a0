// SPDX-License-Identifier: Apache-2.0
// The recipe of the edge network in small: a few minutes on drawn pictures.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/files.h"
#include "engine/vision/edge_detector.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

/// Discs and rectangles of plain colours before stripes, which are no boundaries; and the truth.
std::pair<cv::Mat, cv::Mat> Draw(unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&](int least, int most) {
    return std::uniform_int_distribution<int>(least, most)(random);
  };
  const cv::Size size(160, 160);
  cv::Mat image(size, CV_8UC3), truth(size, CV_8UC1, cv::Scalar(0));
  const int period = draw(4, 9);
  for (int y = 0; y < size.height; ++y)
    image.row(y).setTo(cv::Scalar::all(y / period % 2 == 0 ? 90 : 150));
  for (int i = 0; i < 3; ++i) {
    const cv::Point at(draw(30, 130), draw(30, 130));
    const cv::Scalar color(draw(0, 255), draw(0, 255), draw(0, 255));
    const int radius = draw(12, 30);
    cv::Mat shape(size, CV_8UC1, cv::Scalar(0)), outline;
    if (i % 2 == 0) {
      cv::circle(shape, at, radius, 255, cv::FILLED);
    } else {
      cv::rectangle(shape, at - cv::Point(radius, radius), at + cv::Point(radius, radius / 2), 255,
                    cv::FILLED);
    }
    image.setTo(color, shape);
    truth.setTo(0, shape);
    cv::morphologyEx(shape, outline, cv::MORPH_GRADIENT, cv::Mat::ones(2, 2, CV_8U));
    truth.setTo(255, outline);
  }
  cv::GaussianBlur(image, image, {}, 0.7);
  return {image, truth};
}

struct Quality {
  double precision = 0, recall = 0;
};

/// Of edges of at least `least` (0 to 255) against the truth, within two pixels.
Quality Compare(EdgeDetector& detector, unsigned seed, int least) {
  const auto [image, truth] = Draw(seed);
  Frame frame;
  frame.image = image;
  const EdgeMap edges = detector.Detect(frame).value();
  const cv::Mat found = edges.probability >= least, around = cv::Mat::ones(5, 5, CV_8U);
  cv::Mat near_truth, near_found;
  cv::dilate(truth, near_truth, around);
  cv::dilate(found, near_found, around);
  return {cv::countNonZero(found & near_truth) / std::max(1.0, 1.0 * cv::countNonZero(found)),
          cv::countNonZero(truth & near_found) / static_cast<double>(cv::countNonZero(truth))};
}

TEST(EdgeTraining, LearnsToLeaveOutStripesAndGoesOnAfterABreak) {
  if (std::system("/usr/bin/python3 -c 'import torch, PIL' 2>/dev/null") != 0)
    GTEST_SKIP() << "needs python3-torch and python3-pil";
  const TemporaryFolder folder;
  for (unsigned i = 0; i < 24; ++i) {
    const auto [image, truth] = Draw(i);
    const std::string name = std::to_string(100 + i);
    for (const char* part : {"images/train", "gt/train"})
      std::filesystem::create_directories(folder.path() / part);
    cv::imwrite((folder.path() / "images/train" / (name + ".jpg")).string(), image);
    cv::imwrite((folder.path() / "gt/train" / (name + "_0.png")).string(), truth);
  }
  const auto train = [&](int steps) {
    return std::system(
        ("/usr/bin/python3 '" + (SourceDirectory() / "assets/networks/edge/train.py").string() +
         "' --bsds '" + folder.path().string() + "' --crop 96 --batch 8 --seed 3 --steps " +
         std::to_string(steps) + " --out '" + (folder.path() / "out").string() + "' > '" +
         (folder.path() / "log").string() + "' 2>&1")
            .c_str());
  };
  ASSERT_EQ(train(500), 0) << ReadFile(folder.path() / "log").value();
  ASSERT_EQ(train(600), 0) << ReadFile(folder.path() / "log").value();
  const std::string log = ReadFile(folder.path() / "out/log.csv").value();
  EXPECT_TRUE(log.starts_with("500,"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 2) << log;
  WriteText(folder.path() / "out/edge.json",
            R"({"kind": "edge", "multiple_of": 16, "mean": [104, 117, 123],
                "scale": 0.017241379310344827})");
  const auto network =
      CreateEdgeDetector((folder.path() / "out/edge.onnx").string(), nullptr, {.cache = false});
  ASSERT_TRUE(network.ok()) << network.error().message;
  Quality trained;
  constexpr unsigned kUnseen = 5;
  for (unsigned i = 0; i < kUnseen; ++i) {
    const Quality one = Compare(*network.value(), 1000 + i, 128);
    trained.precision += one.precision / kUnseen;
    trained.recall += one.recall / kUnseen;
  }
  RecordProperty("precision", std::to_string(trained.precision));
  RecordProperty("recall", std::to_string(trained.recall));
  EXPECT_GT(trained.precision, 0.85);
  EXPECT_GT(trained.recall, 0.85);
}

}  // namespace
}  // namespace plumbline
