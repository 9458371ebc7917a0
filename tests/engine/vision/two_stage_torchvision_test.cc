// SPDX-License-Identifier: Apache-2.0
// Against torchvision's own outputs of random weights (two_stage_reference.py).
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/vision/two_stage_detector.h"
#include "engine/vision/two_stage_network.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

constexpr float kTolerance = 1e-3f;

struct ReferenceModel {
  const char* name;
  const char* size;  ///< Of the input; empty: what torchvision makes of 640x480.
};

Box2 BoxOf(const nlohmann::json& corners) {
  return {corners[0], corners[1], corners[2], corners[3]};
}

/// With pixel centres at integers.
Box2 InImage(const nlohmann::json& corners) {
  const Box2 box = BoxOf(corners);
  return {box.x0 - 0.5f, box.y0 - 0.5f, box.x1 - 0.5f, box.y1 - 0.5f};
}

/// The standard deviation of all values.
double Spread(const cv::Mat& tensor) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(tensor.reshape(1, 1), mean, deviation);
  return deviation[0];
}

float LargestDifference(const Box2& a, const Box2& b) {
  return std::max(
      {std::abs(a.x0 - b.x0), std::abs(a.y0 - b.y0), std::abs(a.x1 - b.x1), std::abs(a.y1 - b.y1)});
}

/// A model as exported, with what torchvision makes of two images; made once for all tests of it.
struct ExportedModel {
  explicit ExportedModel(const ReferenceModel& model) {
    const std::string command =
        "/usr/bin/python3 '" +
        (SourceDirectory() / "tests/engine/vision/two_stage_reference.py").string() + "' '" +
        folder.path().string() + "' " + model.name + " " + model.size + " 2>&1";
    const int ended = std::system(command.c_str());
    status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
    if (status != 0) return;
    reference = ReadJson(folder.path() / "reference.json").value();
    network = TwoStageNetwork::Load(file, ReadNetworkSidecar(file).value()).value();
  }
  TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "net.onnx";
  int status = 0;
  nlohmann::json reference;
  std::shared_ptr<TwoStageNetwork> network;
};

class OfTorchvision : public testing::TestWithParam<ReferenceModel> {
 protected:
  void SetUp() override {
    std::unique_ptr<ExportedModel>& model = exported_[GetParam().name];
    if (model == nullptr) model = std::make_unique<ExportedModel>(GetParam());
    if (model->status == 77 || model->status == 127)
      GTEST_SKIP() << "/usr/bin/python3 has no torch and torchvision (python3-torchvision)";
    ASSERT_EQ(model->status, 0);
    file_ = model->file;
    reference_ = model->reference;
    network_ = model->network;
  }
  static void TearDownTestSuite() { exported_.clear(); }
  cv::Mat Image(std::size_t i) const {
    return cv::imread((file_.parent_path() / (std::to_string(i) + ".ppm")).string());
  }

  /// What torchvision's own trunk says of it.
  std::vector<cv::Mat> Levels(std::size_t i) const {
    std::ifstream file(file_.parent_path() / (std::to_string(i) + ".levels"), std::ios::binary);
    std::vector<cv::Mat> levels;
    for (const auto& shape : reference_[i]["shapes"]) {
      levels.emplace_back(shape.get<std::vector<int>>(), CV_32FC1);
      file.read(reinterpret_cast<char*>(levels.back().data),
                static_cast<std::streamsize>(levels.back().total() * sizeof(float)));
    }
    EXPECT_TRUE(file.good());
    return levels;
  }

  std::filesystem::path file_;
  nlohmann::json reference_;
  std::shared_ptr<TwoStageNetwork> network_;

 private:
  static inline std::map<std::string, std::unique_ptr<ExportedModel>> exported_;
};

TEST_P(OfTorchvision, TheTrunkGivesTheSame) {
  for (std::size_t i = 0; i < reference_.size(); ++i) {
    const auto expected = Levels(i);
    const FittedImage fitted = FitImage(Image(i), network_->sidecar());
    ASSERT_EQ(fitted.scale_x, 1);
    const auto levels = network_->RunTrunk(fitted).value();
    ASSERT_EQ(levels.size(), expected.size());
    for (std::size_t k = 0; k < levels.size(); ++k) {
      ASSERT_EQ(levels[k].size, expected[k].size);
      const double share = cv::norm(levels[k], expected[k], cv::NORM_INF) / Spread(expected[k]);
      std::printf("image %zu, level %zu: within %.1e of the spread\n", i, k, share);
      EXPECT_LT(share, kTolerance);
    }
  }
}

// Of torchvision's own trunk: what is decided by thresholds must not depend on the rounding before.
TEST_P(OfTorchvision, TheFirstStageProposesTheSame) {
  for (std::size_t i = 0; i < reference_.size(); ++i) {
    const auto proposals = network_->Propose(Levels(i), FitImage(Image(i), network_->sidecar()));
    const auto& expected = reference_[i]["proposals"];
    ASSERT_EQ(proposals.size(), expected.size());
    EXPECT_GT(proposals.size(), 20u);
    float worst = 0;
    for (std::size_t k = 0; k < expected.size(); ++k) {
      // Among equals torchvision's order is its own.
      const Box2 box = BoxOf(expected[k]);
      const float score = reference_[i]["proposal_scores"][k];
      float least = 1e9f;
      for (const RegionProposal& proposal : proposals)
        least = std::min(least, std::max(LargestDifference(proposal.box, box),
                                         std::abs(proposal.score - score)));
      worst = std::max(worst, least);
    }
    std::printf("image %zu: %zu proposals, corners [px] and scores within %.1e\n", i,
                proposals.size(), static_cast<double>(worst));
    EXPECT_LT(worst, kTolerance);
  }
}

TEST_P(OfTorchvision, TheSecondStageSaysTheSameOfGivenBoxes) {
  for (std::size_t i = 0; i < reference_.size(); ++i) {
    std::vector<Box2> boxes;
    for (const auto& box : reference_[i]["boxes"]) boxes.push_back(BoxOf(box));
    const auto features = network_->Features(Levels(i));
    const HeadScores scores = network_->RunHead(features, boxes).value();
    for (const std::size_t k : {0u, 31u, 130u, 299u}) {
      const HeadScores alone = network_->RunHead(features, {&boxes[k], 1}).value();
      EXPECT_EQ(cv::norm(alone.probabilities, scores.probabilities.row(static_cast<int>(k)),
                         cv::NORM_INF),
                0)
          << "a box's scores depend on its company";
    }
    float worst = 0, worst_corner = 0;
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      const int row = static_cast<int>(k);
      for (int c = 0; c < scores.probabilities.cols; ++c)
        worst = std::max(worst, std::abs(scores.probabilities.at<float>(row, c) -
                                         reference_[i]["probabilities"][k][c].get<float>()));
      for (int c = 1; c <= 3; ++c) {
        const float* deltas = scores.deltas.ptr<float>(row) + 4 * c;
        const Box2 moved = MovedBox(boxes[k], {deltas[0], deltas[1], deltas[2], deltas[3]},
                                    network_->sidecar().two_stage.box_weights);
        const auto& expected = reference_[i]["moved"][k];
        const std::size_t first = 4 * (static_cast<std::size_t>(c) - 1);
        const Box2 torchvisions{expected[first], expected[first + 1], expected[first + 2],
                                expected[first + 3]};
        // Boxes grow up to 62 times: of long ones the share of their length counts.
        const float length = std::max({100.0f, torchvisions.width(), torchvisions.height()});
        worst_corner =
            std::max(worst_corner, LargestDifference(moved, torchvisions) * 100 / length);
      }
    }
    std::printf(
        "image %zu: scores of %zu boxes within %.1e, moved corners within %.1e px per 100 px\n", i,
        boxes.size(), static_cast<double>(worst), static_cast<double>(worst_corner));
    EXPECT_LT(worst, kTolerance);
    EXPECT_LT(worst_corner, kTolerance);
  }
}

// From the image on: the trunk is rounded differently, so a box may fall on the other side of a
// threshold, and corners differ as much as the trunk does.
TEST_P(OfTorchvision, TheDetectorFindsAndScoresTheSame) {
  constexpr float kCornerTolerance = 0.1f;  // [px]
  const auto detector =
      CreateDetector(file_.string(), nullptr, {.min_score = 0.05f, .nms_iou = 0.5f, .cache = false})
          .value();
  const auto& categories = network_->sidecar().categories;
  for (std::size_t i = 0; i < reference_.size(); ++i) {
    Frame frame;
    frame.image = Image(i);
    const auto found = detector->Detect(frame).value();
    const auto& expected = reference_[i]["found"];
    EXPECT_NEAR(found->proposals().size(), expected.size(), 1);
    EXPECT_GT(expected.size(), 5u);
    std::size_t same = 0;
    for (std::size_t k = 0; k < expected.size(); ++k) {
      const Box2 box = InImage(expected[k]);
      const std::string& category =
          categories[reference_[i]["found_labels"][k].get<std::size_t>() - 1];
      const float score = reference_[i]["found_scores"][k];
      same += std::any_of(found->proposals().begin(), found->proposals().end(),
                          [&](const Detection& detection) {
                            return detection.category == category &&
                                   std::abs(detection.score - score) < kTolerance &&
                                   LargestDifference(detection.box, box) < kCornerTolerance;
                          });
    }
    std::printf("image %zu: %zu of %zu boxes found\n", i, same, expected.size());
    EXPECT_GE(same + 1, expected.size());
    // Top-down, the boxes whose corners are quarters of a pixel anyway.
    std::vector<Box2> boxes;
    for (const auto& corners : reference_[i]["boxes"]) boxes.push_back(InImage(corners));
    std::vector<float> scores(boxes.size());
    for (const std::size_t category : {0u, 56u, 61u}) {
      found->ScoreBoxes(categories[category], boxes, scores);
      for (std::size_t k = 0; k < boxes.size(); ++k)
        EXPECT_NEAR(scores[k], reference_[i]["probabilities"][k][category + 1].get<float>(),
                    kTolerance);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Models, OfTorchvision,
                         testing::Values(ReferenceModel{"fasterrcnn_mobilenet_v3_large_320_fpn",
                                                        ""},
                                         ReferenceModel{"mobilenet_light_320", ""},
                                         ReferenceModel{"fasterrcnn_resnet50_fpn", "448x320"},
                                         ReferenceModel{"fasterrcnn_resnet50_fpn_v2", "320x256"}),
                         [](const auto& model) { return std::string(model.param.name); });

}  // namespace
}  // namespace plumbline
