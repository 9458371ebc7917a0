// SPDX-License-Identifier: Apache-2.0
// Against torch's own boxes of random networks that end as YOLOs do (yolo_reference.py).
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/vision/dense_detector.h"
#include "engine/vision/network_guess.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

constexpr float kPixels = 0.01f, kScores = 1e-4f;

/// The proposal of this box, which torch clipped to the image.
bool Has(std::span<const Detection> proposals, const Detection& wanted) {
  return std::any_of(proposals.begin(), proposals.end(), [&](const Detection& found) {
    return found.category == wanted.category && std::abs(found.score - wanted.score) < kScores &&
           std::abs(found.box.x0 - wanted.box.x0) < kPixels &&
           std::abs(found.box.y0 - wanted.box.y0) < kPixels &&
           std::abs(found.box.x1 - wanted.box.x1) < kPixels &&
           std::abs(found.box.y1 - wanted.box.y1) < kPixels;
  });
}

TEST(YoloAsTorchExportsIt, GivesTorchsBoxes) {
  TemporaryFolder folder;
  const std::string command =
      "/usr/bin/python3 '" +
      (SourceDirectory() / "tests/engine/vision/yolo_reference.py").string() + "' '" +
      folder.path().string() + "' 2>&1";
  const int ended = std::system(command.c_str());
  const int status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
  if (status == 77 || status == 127) GTEST_SKIP() << "/usr/bin/python3 has no torch";
  ASSERT_EQ(status, 0);
  Frame frame;
  frame.image = cv::imread((folder.path() / "image.ppm").string());
  const auto reference = ReadJson(folder.path() / "reference.json").value();
  EXPECT_FALSE(reference.empty());
  for (const auto& [name, network] : reference.items()) {
    SCOPED_TRACE(name);
    const std::filesystem::path file = folder.path() / (name + ".onnx");
    const Result<NetworkGuess> guess = GuessSidecar(file);
    ASSERT_TRUE(guess.ok()) << guess.error().message;
    EXPECT_EQ(NameOf(guess->sidecar.kind), network["kind"].get<std::string>());
    // Rounded, the overlap of a box with itself may be more than 1.
    const auto detector = CreateDenseDetector(LoadNetwork(file, guess->sidecar).value(),
                                              {.nms_iou = 2, .cache = false});
    ASSERT_TRUE(detector.ok()) << detector.error().message;
    const auto found = detector.value()->Detect(frame).value();
    ASSERT_FALSE(network["boxes"].empty());
    std::size_t missing = 0;
    for (const auto& box : network["boxes"]) {
      const Box2 corners{box[0], box[1], box[2], box[3]};
      const auto category = box[5].get<std::size_t>();
      const Detection wanted{corners, guess->sidecar.categories[category], box[4]};
      if (!Has(found->proposals(), wanted)) ++missing;
    }
    EXPECT_EQ(missing, 0u) << "of " << network["boxes"].size();
  }
}

}  // namespace
}  // namespace plumbline
