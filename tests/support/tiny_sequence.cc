// SPDX-License-Identifier: Apache-2.0
#include "tests/support/tiny_sequence.h"

#include <opencv2/imgcodecs.hpp>

namespace plumbline {

std::string FrameName(int number) {
  std::string digits = std::to_string(number);
  return std::string(6 - std::min<std::size_t>(6, digits.size()), '0') + digits;
}

void WriteTinySequence(const std::filesystem::path& folder, const TinySequenceOptions& options) {
  WriteText(folder / "camera.json",
            R"({"width": 64, "height": 48, "model": "pinhole", "fx": 60, "fy": 60,
      "cx": 31.5, "cy": 23.5, "distortion": [], "rate_hz": 10})");
  WriteText(folder / "gravity.json", R"({"gravity": [0, 0, -9.81], "floor": [0, 0, 1, 0]})");
  std::string trajectory = "# t tx ty tz qx qy qz qw\n";
  std::filesystem::create_directories(folder / "color");
  if (options.edges) std::filesystem::create_directories(folder / "edges");
  for (int i = 0; i < options.frames; ++i) {
    const std::string name = FrameName(i);
    cv::Mat image(48, 64, CV_8UC3);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        image.at<cv::Vec3b>(y, x) =
            cv::Vec3b(4 * x, 5 * y, static_cast<unsigned char>((x * y + 10 * i) % 256));
      }
    }
    cv::imwrite((folder / "color" / (name + ".jpg")).string(), image);
    trajectory += std::to_string(i * 0.1) + " " + std::to_string(i) + " 0 1 0 0 0 1\n";
    if (options.edges) {
      cv::Mat probability = cv::Mat::zeros(48, 64, CV_8UC1),
              angle = cv::Mat::zeros(48, 64, CV_8UC1);
      probability.col(10 + i) = 200;
      cv::imwrite((folder / "edges" / (name + ".png")).string(), probability);
      cv::imwrite((folder / "edges" / (name + "_angle.png")).string(), angle);
    }
    if (options.proposals) {
      WriteText(
          folder / "proposals" / (name + ".json"),
          R"([{"image": "x.jpg", "boxes": [{"x0": 1, "y0": 2, "x1": 30, "y1": 40, "category": "chair",
                     "score": 0.5}]}])");
    }
  }
  WriteText(folder / "trajectory.txt", trajectory);
}

}  // namespace plumbline
