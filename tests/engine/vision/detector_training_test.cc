// SPDX-License-Identifier: Apache-2.0
// The recipe of the detector in small: pictures are drawn, training goes on after a break, and what
// it exports is a detector of this program.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/files.h"
#include "engine/vision/detector.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

TEST(DetectorTraining, DrawsPicturesTrainsGoesOnAndExports) {
  if (std::system("/usr/bin/python3 -c 'import torch, torchvision, cv2, vtk, onnx' 2>/dev/null && "
                  "command -v xvfb-run > /dev/null") != 0)
    GTEST_SKIP() << "needs python3-torch, python3-torchvision, python3-opencv, python3-vtk9, "
                    "python3-onnx, xvfb";
  if (!SharedData()) GTEST_SKIP() << kNoSharedData;
  const std::filesystem::path teacher = *SharedData() / "models/picodet_s_416/picodet_s_416.onnx";
  if (!std::filesystem::exists(teacher)) GTEST_SKIP() << "needs " << teacher;
  const TemporaryFolder folder;
  const std::string recipe = (SourceDirectory() / "assets/networks/detector").string();
  const auto command = [&](const std::string& words) {
    return std::system(
        ("cd '" + folder.path().string() + "' && " + words + " >> log 2>&1").c_str());
  };
  std::filesystem::create_directories(folder.path() / "photos");
  cv::Mat photo(300, 400, CV_8UC3);
  cv::randu(photo, 0, 255);
  cv::imwrite((folder.path() / "photos/1.jpg").string(), photo);
  ASSERT_EQ(command("xvfb-run -a /usr/bin/python3 '" + recipe +
                    "/draw.py' --out pictures --count 26 --photos photos"),
            0)
      << ReadFile(folder.path() / "log").value();
  std::size_t boxes = 0;
  for (int i = 0; i < 26; ++i) {
    const std::string name = i < 10 ? "00000" + std::to_string(i) : "0000" + std::to_string(i);
    const cv::Mat picture = cv::imread((folder.path() / "pictures" / (name + ".jpg")).string());
    ASSERT_EQ(picture.size(), cv::Size(448, 336));
    const auto labels =
        nlohmann::json::parse(ReadFile(folder.path() / "pictures" / (name + ".json")).value());
    for (const auto& label : labels) {
      EXPECT_LT(label[1].get<int>(), label[3].get<int>());
      EXPECT_LE(label[3].get<int>(), picture.cols);
      EXPECT_LT(label[2].get<int>(), label[4].get<int>());
      EXPECT_LE(label[4].get<int>(), picture.rows);
    }
    boxes += labels.size();
  }
  EXPECT_GT(boxes, 26u) << "more than one object a picture";

  ASSERT_EQ(command("xvfb-run -a /usr/bin/python3 '" + recipe +
                    "/draw.py' --alone --out pieces --count 12 --photos photos"),
            0)
      << ReadFile(folder.path() / "log").value();

  for (const char* steps : {"2", "4"}) {
    ASSERT_EQ(command("/usr/bin/python3 '" + recipe + "/train.py' --photos photos --drawn " +
                      "pictures --pieces pieces --teacher '" + teacher.string() +
                      "' --batch 2 --out out --minutes 60 --steps " + steps),
              0)
        << ReadFile(folder.path() / "log").value();
  }
  const std::string log = ReadFile(folder.path() / "out/log.csv").value();
  EXPECT_TRUE(log.starts_with("2,")) << log;
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 2) << log;

  ASSERT_EQ(command("/usr/bin/python3 '" + recipe +
                    "/export.py' out/weights.pt --out out/detector.onnx --half"),
            0)
      << ReadFile(folder.path() / "log").value();
  const auto detector = CreateDetector((folder.path() / "out/detector.onnx").string(), nullptr, {});
  ASSERT_TRUE(detector.ok()) << detector.error().message;
  Frame frame;
  frame.image = cv::imread((folder.path() / "pictures/000000.jpg").string());
  const auto found = detector.value()->Detect(frame);
  ASSERT_TRUE(found.ok()) << found.error().message;
}

}  // namespace
}  // namespace plumbline
