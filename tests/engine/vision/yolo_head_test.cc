// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/yolo_head.h"

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "engine/vision/dense_detector.h"
#include "engine/vision/network_guess.h"
#include "engine/vision/onnx_for_opencv.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_yolo.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Yolo : public testing::Test {
 protected:
  Result<NetworkGuess> GuessOf(const TinyYolo& yolo) {
    WriteTinyYolo(file_, yolo);
    std::vector<std::string> names = {"chair", "couch"};
    for (int i = 2; i < yolo.categories; ++i) names.push_back("c" + std::to_string(i));
    return GuessSidecar(file_, names);
  }
  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "net.onnx";
};

TEST_F(Yolo, GivesABoxAroundTheMiddleOfEveryCellWhateverItsEndLooksLike) {
  // Sixteen bins and 64 categories: sides and scores look alike.
  const TinyYolo all[] = {{},
                          {.by_level = false},
                          {.categories = 64},
                          {.categories = 64, .by_level = false},
                          {.categories = 4, .bins = 1},
                          {.bins = 1, .by_level = false, .chosen = true},
                          {.chosen = true},
                          {.masks = 32},
                          {.categories = 32, .by_level = false, .masks = 32},
                          {.small_levels = true}};
  for (const TinyYolo& yolo : all) {
    SCOPED_TRACE(&yolo - all);
    const Result<NetworkGuess> guess = GuessOf(yolo);
    ASSERT_TRUE(guess.ok()) << guess.error().message;
    EXPECT_EQ(guess->sidecar.kind, NetworkKind::kYolov8);
    EXPECT_EQ(guess->sidecar.strides.size(), yolo.small_levels ? 4u : 3u);
    const auto detector = CreateDenseDetector(LoadNetwork(file_, guess->sidecar).value(),
                                              {.nms_iou = 2, .cache = false});
    ASSERT_TRUE(detector.ok()) << detector.error().message;
    Frame frame;
    frame.image = cv::Mat(yolo.height, yolo.width, CV_8UC3, cv::Scalar::all(90));
    const auto found = detector.value()->Detect(frame).value();
    EXPECT_EQ(found->proposals().size(), yolo.small_levels ? 256u + 84 : 84u);
    for (const auto& [box, category, score] : found->proposals()) {
      EXPECT_EQ(category, "couch");
      EXPECT_NEAR(score, 0.8, 1e-5);
    }
    // The first cell of stride 8 that is not at the border: its middle is at 12.
    std::vector<float> scores(1);
    found->ScoreBoxes("couch", std::vector{Box2{3.5f, 3.5f, 19.5f, 19.5f}}, scores);
    EXPECT_NEAR(scores[0], 0.8, 1e-4);
  }
}

TEST_F(Yolo, OfOpenSizeIsComputedForTheSizeItIsFed) {
  const Result<NetworkGuess> guess = GuessOf({.free_size = true});
  ASSERT_TRUE(guess.ok()) << guess.error().message;
  EXPECT_EQ(guess->sidecar.kind, NetworkKind::kYolov8);
  EXPECT_EQ(guess->sidecar.width, 640);
  NetworkSidecar small = guess->sidecar;
  small.width = small.height = 96;
  EXPECT_TRUE(CreateDenseDetector(LoadNetwork(file_, small).value(), {}).ok());
}

TEST_F(Yolo, SaysThatItsBoxesAreDecodedHere) {
  const Result<NetworkGuess> guess = GuessOf({.chosen = true});
  ASSERT_TRUE(guess.ok()) << guess.error().message;
  EXPECT_THAT(guess->reasons, testing::Contains(HasSubstr("every cell")));
}

TEST_F(Yolo, MayAlsoBeCalledByTheNameOfItsChosenBoxes) {
  NetworkSidecar sidecar = GuessOf({.chosen = true})->sidecar;
  sidecar.kind = NetworkKind::kYolov10;
  EXPECT_TRUE(CreateDenseDetector(LoadNetwork(file_, sidecar).value(), {}).ok());
}

TEST_F(Yolo, OfAnotherKindIsLeftAloneAndSaysWhatOpenCvCannotDo) {
  const TinyYolo other = {.bins = 1, .chosen = true, .exponential = true};
  const Result<NetworkGuess> guess = GuessOf(other);
  ASSERT_FALSE(guess.ok());
  EXPECT_THAT(guess.error().message, HasSubstr("TopK"));
  EXPECT_THAT(guess.error().message, HasSubstr("nms=False"));
}

}  // namespace
}  // namespace plumbline
