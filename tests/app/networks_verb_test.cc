// SPDX-License-Identifier: Apache-2.0
// `plumbline networks`, and `detect` and `edges` on images and videos, as a script meets them.

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "engine/base/files.h"
#include "engine/dataset/proposals_file.h"
#include "tests/support/program_run.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_network.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::HasSubstr;
using testing::Not;

class NetworksVerb : public testing::Test {
 protected:
  NetworksVerb() {
    cv::imwrite((folder_.path() / "photo.png").string(), cv::Mat(90, 160, CV_8UC3, {90, 90, 90}));
    WriteTinyNetwork(folder_.path() / "net.onnx", {.kind = NetworkKind::kYolov8,
                                                   .width = 96,
                                                   .height = 96,
                                                   .categories = 80,
                                                   .best_category = 56});
    WriteText(folder_.path() / "home/keep", "");
  }
  /// Fetched networks and caches of the user stay out of it.
  ProgramRun Run(const std::string& arguments) const {
    const std::string home = (folder_.path() / "home").string();
    setenv("XDG_DATA_HOME", home.c_str(), 1);
    return RunProgram(arguments + " 2>&1", folder_.path());
  }
  nlohmann::json Json(const char* file) const {
    return nlohmann::json::parse(ReadFile(folder_.path() / file).value());
  }
  TemporaryFolder folder_;
};

TEST_F(NetworksVerb, SaysWhatANetworkIsAndWritesItsSidecarOnlyWhenAsked) {
  ProgramRun run = Run("networks check net.onnx photo.png --out boxes.png");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("yolov8, a guess"));
  EXPECT_THAT(run.output, HasSubstr("80 categories: those of COCO"));
  EXPECT_THAT(run.output, HasSubstr("chair"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "net.json"));
  const cv::Mat picture = cv::imread((folder_.path() / "boxes.png").string());
  ASSERT_EQ(picture.size(), cv::Size(160, 90));
  EXPECT_GT(cv::norm(picture, cv::Mat(90, 160, CV_8UC3, {90, 90, 90})), 0);

  run = Run("detect photo.png --detector net.onnx --json out.json");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.output, HasSubstr("networks check"));
  EXPECT_EQ(Run("networks check net.onnx --write").exit_code, 0);
  run = Run("networks check net.onnx");
  EXPECT_THAT(run.output, HasSubstr("as its sidecar says"));
  EXPECT_EQ(Run("detect photo.png --detector net.onnx --json out.json").exit_code, 0);
  EXPECT_EQ(Json("out.json")[0]["boxes"][0]["category"], "chair");
}

TEST_F(NetworksVerb, NamesTheCategoriesOfOnesOwnNetwork) {
  WriteTinyNetwork(folder_.path() / "own.onnx", {.kind = NetworkKind::kYolox});
  ProgramRun run = Run("networks check own.onnx");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.output, HasSubstr("--categories"));
  WriteText(folder_.path() / "names.txt", "lamp\nSofa\r\n\nshelf\n");
  run = Run("networks check own.onnx photo.png --categories names.txt --write");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(Json("own.json")["categories"], nlohmann::json({"lamp", "couch", "shelf"}));
}

TEST_F(NetworksVerb, ListsAndRefusesInOneSentence) {
  ProgramRun run = Run("networks list");
  EXPECT_EQ(run.exit_code, 0);
  for (const char* name : {"builtin", "builtin-half", "yolox_s", "yolox_nano"})
    EXPECT_THAT(run.output, HasSubstr(name));
  EXPECT_THAT(run.output, Not(HasSubstr("fetched\n")));
  run = Run("networks get yolo_none");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.output, HasSubstr("yolox_nano"));
  run = Run("detect photo.png --json out.json");
  EXPECT_EQ(run.exit_code, 0) << run.output << "the built-in detector needs no file";
  run = Run("detect photo.png --detector yolox_nano --json out.json");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.output, HasSubstr("networks get yolox_nano"));
  WriteText(folder_.path() / "broken.onnx", "no network");
  run = Run("networks check broken.onnx");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.output, HasSubstr("broken.onnx"));
}

TEST_F(NetworksVerb, AVideoIsDetectedFrameByFrame) {
  ASSERT_EQ(Run("networks check net.onnx --write").exit_code, 0);
  {
    cv::VideoWriter video((folder_.path() / "walk.avi").string(),
                          cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10, {160, 90});
    ASSERT_TRUE(video.isOpened());
    for (int i = 0; i < 3; ++i) video.write(cv::Mat(90, 160, CV_8UC3, cv::Scalar::all(40 * i)));
  }
  ProgramRun run =
      Run("detect walk.avi photo.png --detector net.onnx --out boxes --coco coco.json");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  for (const char* file : {"walk_000000.json", "walk_000002.json", "photo.json"}) {
    const auto boxes = ReadProposalsFile(folder_.path() / "boxes" / file);
    ASSERT_TRUE(boxes.ok()) << boxes.error().message;
    EXPECT_EQ(boxes->at(0).category, "chair");
  }
  const nlohmann::json coco = Json("coco.json");
  ASSERT_EQ(coco["images"].size(), 4u);
  EXPECT_EQ(coco["images"][0]["width"], 160);
  EXPECT_EQ(coco["categories"], nlohmann::json::parse(R"([{"id": 62, "name": "chair"}])"));
  const nlohmann::json& box = coco["annotations"][0];
  EXPECT_EQ(box["image_id"], 1);
  EXPECT_EQ(box["category_id"], 62);
  // 24 to 40 of the input's 96 px, which the image's 160 fill from left to right, under a margin
  // of 21.
  EXPECT_NEAR(box["bbox"][0].get<double>(), 24 / 0.6, 0.1);
  EXPECT_NEAR(box["bbox"][1].get<double>(), (24 - 21) / 0.6, 0.1);
  EXPECT_NEAR(box["bbox"][2].get<double>(), 16 / 0.6, 0.1);
  run = Run("edges walk.avi --out edges");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "edges/walk_000001_angle.png"));
  WriteText(folder_.path() / "torn.mp4", "no video");
  run = Run("edges torn.mp4 photo.png --out edges");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.output, HasSubstr("torn.mp4"));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "edges/photo.png"));
}

}  // namespace
}  // namespace plumbline
