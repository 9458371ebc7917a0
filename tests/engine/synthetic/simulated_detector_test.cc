// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/simulated_detector.h"

#include <gtest/gtest.h>

#include <cmath>

namespace plumbline {
namespace {

constexpr int kFrames = 6000;

/// Three objects that never move, before a wall at 3 m.
class Detector : public testing::Test {
 protected:
  void SetUp() override {
    room_.catalogue = {SlatChair(PaletteOfSeed(1), false), RoundTable(PaletteOfSeed(1))};
    room_.instances = {{"chair_1", "chair_slat", "chair"},
                       {"chair_2", "chair_slat", "chair"},
                       {"table_1", "table_round", "dining table"}};
    maps_.depth = cv::Mat(camera_.height, camera_.width, CV_32F, cv::Scalar(3));
    maps_.instance = cv::Mat(camera_.height, camera_.width, CV_16U, cv::Scalar(0));
    visibility_.pixels = {9000, 9000, 20000};
    visibility_.share = {0.9, 0.5, 1.0};
    visibility_.box = {{100, 100, 100, 120}, {300, 120, 90, 200}, {500, 200, 300, 160}};
    visibility_.truncated = {false, false, false};
  }
  /// Intersection over union with the truth of each object, of the best box of its category.
  double BestIou(std::size_t object, const std::vector<Detection>& found) const {
    const cv::Rect& r = visibility_.box[object];
    const Box2 truth{static_cast<float>(r.x), static_cast<float>(r.y),
                     static_cast<float>(r.x + r.width - 1), static_cast<float>(r.y + r.height - 1)};
    double best = 0;
    for (const Detection& detection : found) {
      if (detection.category == room_.instances[object].category)
        best = std::max<double>(best, Iou(truth, detection.box));
    }
    return best;
  }

  Room room_;
  PinholeCamera camera_{960, 500, 560, 560, 480, 250};
  SurfaceMaps maps_;
  Visibility visibility_;
};

TEST_F(Detector, MissesAFifthInBurstsAndAddsHalfAFalseBoxAFrame) {
  SimulatedDetector detector(room_, {}, 4);
  int missed = 0, bursts = 0;
  std::size_t boxes = 0;
  std::array<bool, 3> before{};
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto found =
        detector.Detect(frame, camera_, Eigen::Isometry3d::Identity(), maps_, visibility_);
    boxes += found.size();
    for (std::size_t i = 0; i < 3; ++i) {
      const bool miss = BestIou(i, found) < 0.5;
      missed += miss;
      bursts += miss && !before[i];
      before[i] = miss;
    }
  }
  // 18000 draws whose misses come in bursts of 2.5: one standard deviation is 0.005.
  EXPECT_NEAR(missed / (3.0 * kFrames), 0.20, 0.02);
  EXPECT_GT(static_cast<double>(missed) / bursts, 1.8);
  const double false_per_frame = (static_cast<double>(boxes) - (3.0 * kFrames - missed)) / kFrames;
  EXPECT_NEAR(false_per_frame, 0.5, 0.08);
}

TEST_F(Detector, MissesLastAsLongAtAnyRate) {
  SyntheticOptions options;
  for (const double rate_hz : {30.0, 60.0}) {
    options.rate_hz = rate_hz;
    DetectorFlaws flaws = FlawsOf(options);
    flaws.false_per_frame = 0;
    SimulatedDetector detector(room_, flaws, 4);
    int missed = 0, bursts = 0;
    bool before = false;
    for (int frame = 0; frame < 4 * kFrames; ++frame) {
      const bool miss = BestIou(2, detector.Detect(frame, camera_, Eigen::Isometry3d::Identity(),
                                                   maps_, visibility_)) < 0.5;
      missed += miss;
      bursts += miss && !before;
      before = miss;
    }
    EXPECT_NEAR(missed / (4.0 * kFrames), 0.20, 0.02);
    // 2.5 frames of 30 Hz, 4.3 of 60 Hz; about 1500 bursts give 3 %.
    EXPECT_NEAR(missed / (bursts * rate_hz), 0.078, 0.01);
  }
}

TEST_F(Detector, IsPerfectWithoutFlaws) {
  SyntheticOptions options;
  options.flawless = true;
  SimulatedDetector detector(room_, FlawsOf(options), 4);
  for (int frame = 0; frame < 50; ++frame) {
    const std::vector<Detection> found =
        detector.Detect(frame, camera_, Eigen::Isometry3d::Identity(), maps_, visibility_);
    ASSERT_EQ(found.size(), 3u);
    for (std::size_t instance = 0; instance < 3; ++instance) EXPECT_EQ(BestIou(instance, found), 1);
    for (const Detection& detection : found) EXPECT_FLOAT_EQ(detection.score, 0.95f);
  }
}

TEST_F(Detector, MovesBoxesByATwentiethOfTheirSize) {
  SimulatedDetector detector(room_, {.missed = 0, .false_per_frame = 0}, 4);
  double sum = 0;
  int count = 0;
  for (int frame = 0; frame < 1000; ++frame) {
    for (const Detection& detection :
         detector.Detect(frame, camera_, Eigen::Isometry3d::Identity(), maps_, visibility_)) {
      EXPECT_GE(detection.score, 0.35f);
      EXPECT_LE(detection.score, 0.95f);
      if (detection.category != "dining table") continue;
      const double error = (detection.box.x0 - 500) / 299;
      sum += error * error;
      ++count;
    }
  }
  EXPECT_EQ(count, 1000);
  EXPECT_NEAR(std::sqrt(sum / count), 0.05, 0.005);
}

TEST_F(Detector, DoesNotBoxWhatIsHidden) {
  visibility_.pixels = {100, 5000, 20000};
  visibility_.share = {0.9, 0.05, 1.0};
  SimulatedDetector detector(room_, {.missed = 0, .false_per_frame = 0}, 4);
  const auto found = detector.Detect(0, camera_, Eigen::Isometry3d::Identity(), maps_, visibility_);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].category, "dining table");
}

TEST_F(Detector, SplitsAndDoublesWhenAskedTo) {
  SimulatedDetector detector(room_,
                             {.missed = 0, .false_per_frame = 0, .split = 0.3, .doubled = 0.35}, 4);
  std::size_t boxes = 0;
  for (int frame = 0; frame < 2000; ++frame) {
    boxes +=
        detector.Detect(frame, camera_, Eigen::Isometry3d::Identity(), maps_, visibility_).size();
  }
  EXPECT_NEAR(static_cast<double>(boxes) / (3 * 2000), 1.65, 0.03);
}

TEST_F(Detector, FalseBoxesStayInTheirPlaceInTheRoom) {
  SimulatedDetector detector(room_, {.missed = 1, .false_per_frame = 0.5}, 4);
  visibility_.pixels = {0, 0, 0};
  int followed = 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  std::vector<Detection> before;
  for (int frame = 0; frame < 500; ++frame) {
    pose.translation().x() = 0.01 * frame;  // 1.9 px a frame at 3 m
    const auto found = detector.Detect(frame, camera_, pose, maps_, visibility_);
    for (const Detection& a : found) {
      for (const Detection& b : before)
        followed += a.category == b.category && Iou(a.box, b.box) > 0.6f;
    }
    before = found;
  }
  EXPECT_GT(followed, 80);
}

}  // namespace
}  // namespace plumbline
