// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/edge_detector.h"

#include <gmock/gmock.h>
#include <opencv2/imgproc.hpp>

#include "engine/base/timer.h"
#include "engine/geometry/angles.h"
#include "tests/engine/vision/edge_images.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

EdgeMap Detect(EdgeDetector& detector, const cv::Mat& image) {
  Frame frame;
  frame.image = image;
  return detector.Detect(frame).value();
}

TEST(GradientEdges, KnowTheNormalOfAStepAtEveryAngleAndAreOnePixelWide) {
  const auto detector = CreateEdgeDetector("gradient", nullptr).value();
  for (int degrees = 0; degrees < 180; degrees += 3) {
    const StraightEdge edge{degrees * kRadPerDeg, 0.3};
    const LineQuality quality = MeasureLine(Detect(*detector, StepImage(edge, 80, 0)), edge);
    EXPECT_LT(quality.worst_angle_deg, 3) << degrees;
    EXPECT_NEAR(quality.pixels_per_step, 1, 0.03) << degrees;
    EXPECT_NEAR(quality.mean_offset_px, 0, 0.31)
        << degrees;  // the nearest row of pixels is 0.3 off at 45 degrees
  }
}

TEST(GradientEdges, StandTheNoiseOfACamera) {
  const auto detector = CreateEdgeDetector("gradient", nullptr).value();
  for (int degrees = 0; degrees < 180; degrees += 15) {
    const StraightEdge edge{degrees * kRadPerDeg, 0.3};
    const LineQuality quality = MeasureLine(Detect(*detector, StepImage(edge, 40, 4)), edge, 64);
    EXPECT_LT(quality.mean_angle_deg, 5) << degrees;
    EXPECT_NEAR(quality.pixels_per_step, 1, 0.15) << degrees;  // noise makes it sway by a pixel
    EXPECT_LT(quality.strays, 10) << degrees;                  // of 8 000 pixels
  }
}

TEST(GradientEdges, FindNothingOnAGreyWallAndTakeImagesOfAnySize) {
  const auto detector = CreateEdgeDetector("gradient", nullptr).value();
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(2, 3), cv::Size(7, 5), cv::Size(33, 1), cv::Size(321, 241)}) {
    const EdgeMap edges = Detect(*detector, cv::Mat(size, CV_8UC3, cv::Scalar(90, 120, 140)));
    EXPECT_EQ(edges.probability.size(), size);
    EXPECT_EQ(edges.angle.size(), size);
    EXPECT_EQ(cv::countNonZero(edges.probability), 0);
  }
}

TEST(CreateEdgeDetector, SaysWhatIsWrongWithTheChoice) {
  const auto message = [](const std::string& choice) {
    return CreateEdgeDetector(choice, nullptr).error().message;
  };
  EXPECT_THAT(message("canny"), HasSubstr("'canny'"));
  EXPECT_THAT(message("dataset"), HasSubstr("sequence"));
  EXPECT_THAT(message("nowhere.onnx"), HasSubstr("there is no network 'nowhere.onnx'"));
}

TEST(DatasetEdges, AreThoseOfTheSequence) {
  const TemporaryFolder folder;
  WriteTinySequence(folder.path(), {.edges = true});
  std::filesystem::remove(folder.path() / "edges/000003.png");
  const auto sequence = OpenSequence(folder.path()).value();
  const auto detector = CreateEdgeDetector("dataset", sequence).value();
  EXPECT_EQ(
      detector->Detect(sequence->ReadFrame(1).value()).value().probability.at<unsigned char>(3, 11),
      200);
  EXPECT_EQ(detector->Detect(sequence->ReadFrame(3).value()).error().code, ErrorCode::kNotFound);
}

class TrialNetwork : public testing::Test {
 protected:
  void SetUp() override {
    if (!SharedData()) GTEST_SKIP() << kNoSharedData;
    detector_ =
        CreateEdgeDetector((*SharedData() / "models/edge_trial/t0_480x640.onnx").string(), nullptr)
            .value();
  }
  std::unique_ptr<EdgeDetector> detector_;
};

TEST_F(TrialNetwork, KnowsTheNormalOfAStepAndIsOnePixelWide) {
  for (int degrees = 0; degrees < 180; degrees += 30) {
    const StraightEdge edge{degrees * kRadPerDeg, 0.3, 300};
    const EdgeMap edges = Detect(*detector_, StepImage(edge, 80, 3));
    EXPECT_EQ(edges.probability.size(), cv::Size(300, 300));  // padded to 640x480 inside
    const LineQuality quality = MeasureLine(edges, edge);
    EXPECT_LT(quality.mean_angle_deg, 3) << degrees;
    EXPECT_NEAR(quality.pixels_per_step, 1, 0.1) << degrees;
  }
}

TEST_F(TrialNetwork, ShrinksLargerImages) {
  const StraightEdge edge{60 * kRadPerDeg, 0.3, 900};
  const LineQuality quality = MeasureLine(Detect(*detector_, StepImage(edge, 80, 3)), edge);
  EXPECT_LT(quality.mean_angle_deg, 3);
  EXPECT_NEAR(quality.pixels_per_step, 1, 0.2);
}

TEST_F(TrialNetwork, GivesTheSameEdgesWhateverTheNumberOfThreads) {
  const auto sequence = OpenSequence(*SharedData() / "data/kitchen").value();
  const Frame frame = sequence->ReadFrame(30).value();
  const int threads = cv::getNumThreads();
  std::vector<EdgeMap> maps;
  for (const int n : {1, 2, 2}) {
    cv::setNumThreads(n);
    maps.push_back(detector_->Detect(frame).value());
  }
  cv::setNumThreads(threads);
  for (const EdgeMap& map : maps) {
    EXPECT_EQ(cv::norm(map.probability, maps[0].probability, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(map.angle, maps[0].angle, cv::NORM_INF), 0);
  }
}

TEST(BuiltinEdges, FindOutlinesOfAnySizeAlike) {
  for (const char* choice : {"builtin", "builtin-half"}) {
    const auto network = CreateEdgeDetector(choice, nullptr, {.cache = false});
    ASSERT_TRUE(network.ok()) << network.error().message;
    for (const cv::Size size : {cv::Size(321, 241), cv::Size(640, 480), cv::Size(90, 66)}) {
      Frame frame;
      frame.image = cv::Mat(size, CV_8UC3, cv::Scalar(60, 90, 120));
      const cv::Rect box(size.width / 4, size.height / 4, size.width / 2, size.height / 2);
      cv::rectangle(frame.image, box, {210, 200, 190}, cv::FILLED);
      const Result<EdgeMap> edges = network.value()->Detect(frame);
      ASSERT_TRUE(edges.ok()) << edges.error().message;
      ASSERT_EQ(edges->probability.size(), size);
      cv::Mat border(size, CV_8UC1, cv::Scalar(0)), near_border;
      cv::rectangle(border, box, 255);
      constexpr int around = 7;  // [px]
      cv::dilate(border, near_border, cv::Mat::ones(around, around, CV_8U));
      const cv::Mat strong = edges->probability > 100;
      EXPECT_GT(cv::countNonZero(strong & near_border), 1.4 * (box.width + box.height))
          << choice << size;
      EXPECT_LT(cv::countNonZero(strong & ~near_border), 0.1 * (box.width + box.height))
          << choice << size;
    }
  }
}

}  // namespace
}  // namespace plumbline
