// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/two_stage_detector.h"

#include <cmath>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/random.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_network.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

class TwoStage : public testing::Test {
 protected:
  void SetUp() override { WriteTinyTwoStage(file_); }
  std::unique_ptr<Detector> Create() {
    return CreateDetector(file_.string(), nullptr, {.cache = false}).value();
  }
  std::string Refusal() const {
    const auto detector = CreateDetector(file_.string(), nullptr);
    return detector.ok() ? "accepted" : detector.error().message;
  }
  void Change(const std::function<void(nlohmann::json&)>& edit) const {
    const auto sidecar = std::filesystem::path(file_).replace_extension(".json");
    nlohmann::json json = ReadJson(sidecar).value();
    edit(json);
    ASSERT_TRUE(WriteJson(sidecar, json).ok());
  }
  /// Dark, and white from column 32 of 64 on.
  static Frame HalfWhite(int factor) {
    Frame frame;
    frame.image = cv::Mat(32 * factor, 64 * factor, CV_8UC3, cv::Scalar::all(0));
    frame.image.colRange(32 * factor, 64 * factor).setTo(cv::Scalar::all(255));
    return frame;
  }
  static std::vector<float> Scores(const FrameDetections& found, std::string_view category,
                                   const std::vector<Box2>& boxes) {
    std::vector<float> scores(boxes.size(), -1);
    found.ScoreBoxes(category, boxes, scores);
    return scores;
  }
  /// Of a mean grey level.
  static double Couch(double mean) { return 1 / (1 + std::exp(-20 * (mean - 0.5))); }

  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "net.onnx";
};

// Corners of boxes are pixel centres, the edge of the image is at -0.5.
TEST_F(TwoStage, ScoresABoxByWhatItsCropShows) {
  for (const int factor : {1, 2}) {
    const auto found = Create()->Detect(HalfWhite(factor)).value();
    const auto f = static_cast<float>(factor);
    const auto box = [&](float x0, float x1) {
      return Box2{x0 * f - 0.5f, 2 * f - 0.5f, x1 * f - 0.5f, 20 * f - 0.5f};
    };
    // Cells of 8 px: the ramp from black to white lies between the columns 24 and 32.
    double ramp = 0;
    for (int i = 0; i < 14; ++i) ramp += std::min(1.0, (i + 0.5) / 14 * 14 / 8) / 14;
    const auto scores =
        Scores(*found, "couch",
               {box(40, 60), box(2, 20), box(24, 38), box(20, 20), box(-30, -2), box(40, 900)});
    EXPECT_NEAR(scores[0], Couch(1), 1e-4);
    EXPECT_NEAR(scores[1], Couch(0), 1e-4);
    EXPECT_NEAR(scores[2], Couch(ramp), 1e-4);
    EXPECT_EQ(scores[3], 0);                 // empty
    EXPECT_EQ(scores[4], 0);                 // outside of the image
    EXPECT_NEAR(scores[5], Couch(1), 1e-4);  // its part within the image
    EXPECT_NEAR(Scores(*found, "chair", {box(40, 60)})[0], 0, 1e-4);
    EXPECT_EQ(Scores(*found, "zebra", {box(40, 60)})[0], 0);
  }
}

TEST_F(TwoStage, ProposesWhatTheSecondStageConfirms) {
  const auto found = Create()->Detect(HalfWhite(2)).value();
  ASSERT_FALSE(found->proposals().empty());
  for (const auto& [box, category, score] : found->proposals()) {
    EXPECT_EQ(category, "couch");
    EXPECT_GE(score, 0.1f);
    EXPECT_GE(box.x0, 2 * (32 - 8) - 0.5f - 1e-3f);  // an anchor on the first white cell
    EXPECT_LE(box.x1, 127.5f);
    EXPECT_LE(box.y1, 63.5f);
    // The stages agree: the network leaves boxes where they are.
    EXPECT_NEAR(Scores(*found, "couch", {box})[0], score, 1e-4);
  }
}

TEST_F(TwoStage, ScoresDoNotDependOnCompanyThreadsOrOrder) {
  Frame frame;
  frame.image = cv::Mat(64, 64, CV_8UC3);
  cv::RNG(7).fill(frame.image, cv::RNG::UNIFORM, 0, 256);
  Random random({.seed = 3});
  std::vector<Box2> boxes;
  for (int i = 0; i < 300; ++i) {
    const auto x = static_cast<float>(random.Uniform(-5, 40)),
               y = static_cast<float>(random.Uniform(-5, 40));
    boxes.push_back({x, y, x + static_cast<float>(random.Uniform(1, 40)),
                     y + static_cast<float>(random.Uniform(1, 40))});
  }
  const auto detector = Create();
  const auto expected = Scores(*detector->Detect(frame).value(), "couch", boxes);
  const auto one_by_one = detector->Detect(frame).value();
  for (std::size_t i = boxes.size(); i-- > 0;)
    EXPECT_EQ(Scores(*one_by_one, "couch", {boxes[i]})[0], expected[i]);
  const int threads = cv::getNumThreads();
  for (const int n : {1, 2}) {
    cv::setNumThreads(n);
    const auto shared = detector->Detect(frame).value();
    std::vector<std::vector<float>> results(4);
    std::vector<std::thread> askers;
    for (std::size_t asker = 0; asker < results.size(); ++asker) {
      askers.emplace_back([&, asker] {
        // Overlapping parts of the boxes, each twice.
        const std::vector<Box2> part(boxes.begin() + static_cast<std::ptrdiff_t>(50 * asker),
                                     boxes.end());
        results[asker] = Scores(*shared, "chair", part);
        results[asker] = Scores(*shared, "couch", part);
      });
    }
    for (std::thread& asker : askers) asker.join();
    for (std::size_t asker = 0; asker < results.size(); ++asker)
      for (std::size_t i = 0; i < results[asker].size(); ++i)
        EXPECT_EQ(results[asker][i], expected[50 * asker + i]);
  }
  cv::setNumThreads(threads);
}

TEST_F(TwoStage, SaysTheSameFromTheCache) {
  const std::vector<Box2> boxes = {{40, 2, 60, 20}, {20, 2, 45, 20}};
  const auto fresh = Create()->Detect(HalfWhite(2)).value();
  for (int i = 0; i < 2; ++i) {
    const auto found =
        CreateDetector(file_.string(), nullptr).value()->Detect(HalfWhite(2)).value();
    EXPECT_EQ(Scores(*found, "couch", boxes), Scores(*fresh, "couch", boxes));
    ASSERT_EQ(found->proposals().size(), fresh->proposals().size());
    for (std::size_t k = 0; k < found->proposals().size(); ++k)
      EXPECT_EQ(found->proposals()[k].box, fresh->proposals()[k].box);
  }
}

TEST_F(TwoStage, OutlivesItsDetector) {
  auto detector = Create();
  const auto found = detector->Detect(HalfWhite(1)).value();
  detector.reset();
  EXPECT_NEAR(Scores(*found, "couch", {{40, 2, 60, 20}})[0], Couch(1), 1e-4);
}

TEST_F(TwoStage, SurvivesTheWayThroughItsSidecar) {
  const Result<NetworkSidecar> sidecar = ReadNetworkSidecar(file_);
  ASSERT_TRUE(sidecar.ok()) << sidecar.error().message;
  const Result<NetworkSidecar> back = SidecarFromJson(SidecarToJson(*sidecar));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(SidecarToJson(*back), SidecarToJson(*sidecar));
  EXPECT_EQ(back->two_stage.proposals_after_nms, 20);
}

TEST_F(TwoStage, WithoutAHeadIsAnError) {
  std::filesystem::remove(folder_.path() / "net.head.onnx");
  EXPECT_THAT(Refusal(), HasSubstr("net.head.onnx"));
  WriteText(folder_.path() / "net.head.onnx", "no network");
  EXPECT_THAT(Refusal(), HasSubstr("net.head.onnx"));
}

TEST_F(TwoStage, WithAHeadOfOtherCategoriesIsAnError) {
  WriteTinyTwoStage(file_, 5);
  EXPECT_THAT(Refusal(), HasSubstr("net.head.onnx' gives outputs of 32x30"));
  EXPECT_THAT(Refusal(), HasSubstr("2 categories"));
}

TEST_F(TwoStage, WithATrunkOfOtherShapesIsAnError) {
  const std::string wrong = "net.onnx' gives outputs of 1x6x8x8, which its sidecar";
  Change([](auto& json) { json["strides"] = {16}; });
  EXPECT_THAT(Refusal(), HasSubstr(wrong));
  Change([](auto& json) {
    json["strides"] = {8};
    json["anchors"][0]["ratios"] = {1, 2};
  });
  EXPECT_THAT(Refusal(), HasSubstr(wrong));
  Change([](auto& json) {
    json["strides"] = {8, 16};
    json["anchors"] = {json["anchors"][0], json["anchors"][0]};
  });
  EXPECT_THAT(Refusal(), HasSubstr(wrong));
}

TEST_F(TwoStage, WithASidecarThatLacksSomethingIsAnError) {
  const nlohmann::json good = ReadJson(folder_.path() / "net.json").value();
  const auto refusal_without = [&](const nlohmann::json::json_pointer& what) {
    nlohmann::json json = good;
    json[what.parent_pointer()].erase(what.back());
    EXPECT_TRUE(WriteJson(folder_.path() / "net.json", json).ok());
    return Refusal();
  };
  for (const char* what : {"/anchors", "/strides", "/rpn", "/crops", "/boxes", "/rpn/weights",
                           "/crops/size", "/rpn/nms_iou", "/boxes/most", "/resize"}) {
    const nlohmann::json::json_pointer pointer(what);
    EXPECT_THAT(refusal_without(pointer), HasSubstr("net.json")) << what;
    EXPECT_THAT(refusal_without(pointer), HasSubstr(pointer.back())) << what;
  }
  for (const auto& [where, value] :
       std::vector<std::pair<const char*, nlohmann::json>>{{"/anchors/0/sizes", {-16}},
                                                           {"/anchors/0", 3},
                                                           {"/rpn/after_nms", 0.5},
                                                           {"/crops/levels", 2},
                                                           {"/boxes/weights", {1, 1, 0, 1}}}) {
    nlohmann::json json = good;
    json[nlohmann::json::json_pointer(where)] = value;
    ASSERT_TRUE(WriteJson(folder_.path() / "net.json", json).ok());
    EXPECT_THAT(Refusal(), HasSubstr("net.json")) << where;
  }
}

}  // namespace
}  // namespace plumbline
