// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/network_guess.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/vision/category_names.h"
#include "engine/vision/dense_detector.h"
#include "engine/vision/edge_network.h"
#include "engine/vision/network.h"
#include "engine/vision/proposals.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_network.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> kThree = {"chair", "Sofa", "TV_monitor"};

/// All kinds that have boxes, by the network that is their smallest.
class OfKind : public testing::TestWithParam<NetworkKind> {
 protected:
  void SetUp() override {
    file_ = folder_.path() / "net.onnx";
    network_.kind = GetParam();
    WriteTinyNetwork(file_, network_);
  }
  TemporaryFolder folder_;
  std::filesystem::path file_;
  TinyNetwork network_;
};

TEST_P(OfKind, IsKnownByTheShapesOfItsOutputs) {
  const Result<NetworkGuess> guess = GuessSidecar(file_, kThree);
  ASSERT_TRUE(guess.ok()) << guess.error().message;
  EXPECT_EQ(guess->sidecar.kind, GetParam());
  EXPECT_EQ(guess->sidecar.width, 64);
  EXPECT_THAT(guess->sidecar.categories, ElementsAre("chair", "couch", "tv"));
  EXPECT_FALSE(guess->reasons.empty());
}

TEST_P(OfKind, FindsItsBoxesInImagesOfOtherSizes) {
  const NetworkSidecar sidecar = GuessSidecar(file_, kThree)->sidecar;
  // Wide and tall: letterboxes have margins on one side, then on the other.
  for (const cv::Size size : {cv::Size(64, 64), cv::Size(256, 128), cv::Size(100, 200)}) {
    Frame frame;
    frame.image = cv::Mat(size, CV_8UC3, cv::Scalar::all(90));
    const auto detector =
        CreateDenseDetector(LoadNetwork(file_, sidecar).value(), {.cache = false});
    ASSERT_TRUE(detector.ok()) << detector.error().message;
    const auto found = detector.value()->Detect(frame).value();
    ASSERT_FALSE(found->proposals().empty());
    const bool stretch = sidecar.fit == ImageFit::kStretch;
    const double longest = std::max(size.width, size.height);
    const double across = stretch ? size.width / 64.0 : longest / 64.0;
    const double down = stretch ? size.height / 64.0 : longest / 64.0;
    // Boxes inside of the image are 16 px of the input wide and high.
    int whole = 0;
    for (const auto& [box, category, score] : found->proposals()) {
      EXPECT_EQ(category, "couch");
      EXPECT_NEAR(score, GetParam() == NetworkKind::kFastestDet ? std::pow(0.8, 0.4) : 0.8, 1e-4);
      if (box.x0 <= -0.5f || box.y0 <= -0.5f || box.x1 >= static_cast<float>(size.width) - 0.5f ||
          box.y1 >= static_cast<float>(size.height) - 0.5f)
        continue;
      ++whole;
      EXPECT_NEAR(box.x1 - box.x0, 16 * across, 1e-2);
      EXPECT_NEAR(box.y1 - box.y0, 16 * down, 1e-2);
    }
    EXPECT_GT(whole, 0);
    const Box2 best = found->proposals().front().box;
    std::vector<float> scores(1);
    found->ScoreBoxes("couch", std::vector{best}, scores);
    EXPECT_NEAR(scores[0], found->proposals().front().score, 1e-4);
    found->ScoreBoxes("chair", std::vector{best}, scores);
    EXPECT_EQ(scores[0], 0);
  }
}

TEST_P(OfKind, IsRefusedWithASidecarOfAnother) {
  NetworkSidecar sidecar = GuessSidecar(file_, kThree)->sidecar;
  sidecar.categories.push_back("lamp");
  sidecar.categories.push_back("shelf");
  // Boxes that are chosen already do not say how many categories there are.
  if (sidecar.kind == NetworkKind::kYolov10) sidecar.kind = NetworkKind::kYolov8;
  const auto too_many = CreateDenseDetector(LoadNetwork(file_, sidecar).value(), {});
  ASSERT_FALSE(too_many.ok());
  EXPECT_EQ(too_many.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(too_many.error().message, HasSubstr("does not explain"));
  EXPECT_THAT(too_many.error().message, HasSubstr("net.onnx"));
}

TEST_P(OfKind, SurvivesTheWayThroughItsSidecar) {
  const NetworkSidecar sidecar = GuessSidecar(file_, kThree)->sidecar;
  const Result<NetworkSidecar> back = SidecarFromJson(SidecarToJson(sidecar));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(SidecarToJson(*back), SidecarToJson(sidecar));
}

INSTANTIATE_TEST_SUITE_P(Detectors, OfKind,
                         testing::Values(NetworkKind::kFastestDet, NetworkKind::kYolox,
                                         NetworkKind::kYolov5, NetworkKind::kYolov8,
                                         NetworkKind::kPicodet, NetworkKind::kNanodet,
                                         NetworkKind::kSsd, NetworkKind::kYolov10),
                         [](const auto& of) { return std::string(NameOf(of.param)); });

class Guess : public testing::Test {
 protected:
  std::string Refusal(const TinyNetwork& network, const std::vector<std::string>& names) {
    WriteTinyNetwork(file_, network);
    const Result<NetworkGuess> guess = GuessSidecar(file_, names);
    return guess.ok() ? "accepted" : guess.error().message;
  }
  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "net.onnx";
};

TEST_F(Guess, TakesNamesAndSizeFromTheExportersNotes) {
  WriteTinyNetwork(file_, {.kind = NetworkKind::kYolov8,
                           .free_size = true,
                           .metadata = {{"names", "{0: 'chair', 1: 'Potted Plant', 2: 'sofa'}"},
                                        {"imgsz", "[96, 160]"}}});
  const Result<NetworkGuess> guess = GuessSidecar(file_);
  ASSERT_TRUE(guess.ok()) << guess.error().message;
  EXPECT_EQ(guess->sidecar.width, 160);
  EXPECT_EQ(guess->sidecar.height, 96);
  EXPECT_THAT(guess->sidecar.categories, ElementsAre("chair", "potted plant", "couch"));
}

TEST_F(Guess, OfEightyCategoriesIsCoco) {
  WriteTinyNetwork(file_, {.kind = NetworkKind::kYolox, .categories = 80});
  EXPECT_EQ(GuessSidecar(file_)->sidecar.categories[56], "chair");
  WriteTinyNetwork(file_, {.kind = NetworkKind::kSsd, .categories = 20});
  EXPECT_EQ(GuessSidecar(file_)->sidecar.categories[8], "chair");
}

TEST_F(Guess, AsksForNamesThatItCannotKnow) {
  EXPECT_THAT(Refusal({.kind = NetworkKind::kYolox}, {}), HasSubstr("--categories"));
  EXPECT_THAT(Refusal({.kind = NetworkKind::kYolox}, {"one", "two"}), HasSubstr("2 names"));
}

TEST_F(Guess, RefusesWhatItDoesNotKnow) {
  WriteText(file_, "no network");
  EXPECT_EQ(GuessSidecar(file_).error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(Refusal({.kind = NetworkKind::kEdge, .width = 2000000, .height = 2000000}, {}),
              HasSubstr("2000000x2000000"));
  EXPECT_EQ(GuessSidecar(folder_.path() / "none.onnx").error().code, ErrorCode::kNotFound);
}

TEST_F(Guess, LoadsBoundsOfClipsThatAreInputs) {
  WriteTinyNetwork(file_, {.kind = NetworkKind::kYolox, .clips = true});
  const Result<NetworkGuess> guess = GuessSidecar(file_, kThree);
  EXPECT_TRUE(guess.ok()) << guess.error().message;
}

TEST_F(Guess, LoadsCopiesOfConstants) {
  WriteTinyNetwork(file_, {.kind = NetworkKind::kYolox, .copies = true});
  const Result<NetworkGuess> guess = GuessSidecar(file_, kThree);
  EXPECT_TRUE(guess.ok()) << guess.error().message;
}

TEST_F(Guess, ComputesShapesOfWhichTheInputTellsAll) {
  WriteTinyNetwork(file_, {.kind = NetworkKind::kYolox, .shapes = true});
  EXPECT_TRUE(GuessSidecar(file_, kThree).ok()) << GuessSidecar(file_, kThree).error().message;
  WriteTinyNetwork(file_, {.kind = NetworkKind::kYolox,
                           .shapes = true,
                           .free_size = true,
                           .metadata = {{"imgsz", "[96, 160]"}}});
  const Result<NetworkGuess> guess = GuessSidecar(file_, kThree);
  ASSERT_TRUE(guess.ok()) << guess.error().message;
  EXPECT_EQ(guess->sidecar.width, 160);
  EXPECT_TRUE(CreateDenseDetector(LoadNetwork(file_, guess->sidecar).value(), {}).ok());
}

TEST_F(Guess, CountsCategoriesWithoutTheNumbersOfMasks) {
  for (const NetworkKind kind : {NetworkKind::kYolov5, NetworkKind::kYolov8}) {
    WriteTinyNetwork(file_, {.kind = kind, .masks = 32});
    const Result<NetworkGuess> guess = GuessSidecar(file_, kThree);
    ASSERT_TRUE(guess.ok()) << guess.error().message;
    EXPECT_EQ(guess->sidecar.kind, kind);
    const auto detector = CreateDenseDetector(LoadNetwork(file_, guess->sidecar).value(), {});
    ASSERT_TRUE(detector.ok()) << detector.error().message;
    Frame frame;
    frame.image = cv::Mat(64, 64, CV_8UC3, cv::Scalar::all(90));
    const auto found = detector.value()->Detect(frame).value();
    ASSERT_FALSE(found->proposals().empty());
    EXPECT_EQ(found->proposals()[0].category, "couch");
  }
}

TEST_F(Guess, OfChosenBoxesNeedsTheNames) {
  EXPECT_THAT(Refusal({.kind = NetworkKind::kYolov10}, {}),
              HasSubstr("does not say which categories"));
}

TEST_F(Guess, OfAnEdgeNetwork) {
  WriteTinyNetwork(file_, {.kind = NetworkKind::kEdge});
  const Result<NetworkGuess> guess = GuessSidecar(file_);
  ASSERT_TRUE(guess.ok()) << guess.error().message;
  EXPECT_EQ(guess->sidecar.kind, NetworkKind::kEdge);
  EXPECT_TRUE(CreateEdgeNetwork(LoadNetwork(file_, guess->sidecar).value(), {}).ok());
  const auto as_detector = CreateDenseDetector(LoadNetwork(file_, guess->sidecar).value(), {});
  EXPECT_FALSE(as_detector.ok());
}

TEST(CategoryNames, AreThoseOfCocoWhateverTheWord) {
  for (const auto& [word, name] :
       std::vector<std::pair<const char*, const char*>>{{"sofa", "couch"},
                                                        {"tvmonitor", "tv"},
                                                        {"Dining_Table", "dining table"},
                                                        {"diningtable", "dining table"},
                                                        {"pottedplant", "potted plant"},
                                                        {"aeroplane", "airplane"},
                                                        {"Chair", "chair"},
                                                        {"My_Shelf", "my shelf"},
                                                        {"desk", "desk"}}) {
    EXPECT_EQ(CategoryName(word), name);
  }
  EXPECT_EQ(CocoCategories().size(), 80u);
  EXPECT_EQ(VocCategories().size(), 20u);
  for (const std::string_view name : VocCategories())
    EXPECT_NE(std::find(CocoCategories().begin(), CocoCategories().end(), name),
              CocoCategories().end())
        << name;
}

/// Public networks on a kitchen frame, by the worked examples beside them.
class PublicNetworks : public testing::Test {
 protected:
  void SetUp() override {
    if (!SharedData()) GTEST_SKIP() << kNoSharedData;
    frame_.image = cv::imread((*SharedData() / "data/kitchen/color/000100.jpg").string());
    ASSERT_FALSE(frame_.image.empty());
  }
  /// The proposals of the network as guessed.
  std::vector<Detection> Find(const std::string& file, NetworkKind kind) {
    const Result<NetworkGuess> guess = GuessSidecar(*SharedData() / file);
    if (!guess.ok()) {
      ADD_FAILURE() << guess.error().message;
      return {};
    }
    EXPECT_EQ(guess->sidecar.kind, kind);
    auto network = LoadNetwork(*SharedData() / file, guess->sidecar).value();
    const auto detector =
        CreateDenseDetector(std::move(network), {.min_score = 0.4f, .cache = false}).value();
    const auto found = detector->Detect(frame_).value();
    return {found->proposals().begin(), found->proposals().end()};
  }
  /// Corners as the examples count them, from the image's edge. The middle of its tolerances: JPEG
  /// decoders differ.
  static void ExpectBox(const Detection& found, const char* category, float score, Box2 box) {
    EXPECT_EQ(found.category, category);
    EXPECT_NEAR(found.score, score, 0.005);
    EXPECT_NEAR(found.box.x0 + 0.5f, box.x0, 1);
    EXPECT_NEAR(found.box.y0 + 0.5f, box.y0, 1);
    EXPECT_NEAR(found.box.x1 + 0.5f, box.x1, 1);
    EXPECT_NEAR(found.box.y1 + 0.5f, box.y1, 1);
  }
  Frame frame_;
};

TEST_F(PublicNetworks, YoloxNanoFindsWhatItsExampleSays) {
  const auto found = Find("models/yolox_nano/yolox_nano.onnx", NetworkKind::kYolox);
  ASSERT_EQ(found.size(), 3u);
  ExpectBox(found[0], "chair", 0.649f, {409.9f, 148.2f, 624.7f, 473.5f});
  ExpectBox(found[1], "sink", 0.493f, {152.7f, 21.7f, 323.2f, 74.4f});
  ExpectBox(found[2], "chair", 0.483f, {423.6f, 154.9f, 589.1f, 305.0f});
}

TEST_F(PublicNetworks, PicoDetFindsWhatItsExampleSays) {
  const auto found = Find("models/picodet_s_416/picodet_s_416.onnx", NetworkKind::kPicodet);
  ASSERT_EQ(found.size(), 3u);
  ExpectBox(found[0], "chair", 0.847f, {391.5f, 153.3f, 597.1f, 477.7f});
  ExpectBox(found[1], "dining table", 0.517f, {4.2f, 1.3f, 640.0f, 477.9f});
  ExpectBox(found[2], "cup", 0.447f, {203.1f, 2.9f, 228.7f, 48.1f});
}

TEST_F(PublicNetworks, FastestDetAndTheEdgeTrialAreKnown) {
  const auto fastest = GuessSidecar(*SharedData() / "models/fastestdet/FastestDet.onnx");
  ASSERT_TRUE(fastest.ok()) << fastest.error().message;
  EXPECT_EQ(fastest->sidecar.kind, NetworkKind::kFastestDet);
  EXPECT_EQ(fastest->sidecar.width, 352);
  const auto edge = GuessSidecar(*SharedData() / "models/edge_trial/t0_480x640.onnx");
  ASSERT_TRUE(edge.ok()) << edge.error().message;
  EXPECT_EQ(edge->sidecar.kind, NetworkKind::kEdge);
}

}  // namespace
}  // namespace plumbline
