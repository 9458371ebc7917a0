// SPDX-License-Identifier: Apache-2.0
// What a frame costs before the mapper sees it, one core. Canny and a full-size network are the
// yardsticks:
//   vision_benchmark [IMAGE] [EDGES.onnx] [DETECTOR.onnx]
// Without an image a noisy drawing serves.

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <vector>

#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"
#include "engine/sensor/image_file.h"
#include "engine/vision/detector.h"
#include "engine/vision/edge_detector.h"

namespace plumbline {
namespace {

double CpuMilliseconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// Median and least CPU time of 31 runs after one to warm up; returns the median.
double Measure(const char* name, double yardstick, const std::function<void()>& run) {
  run();
  std::vector<double> times;
  for (int i = 0; i < 31; ++i) {
    const double start = CpuMilliseconds();
    run();
    times.push_back(CpuMilliseconds() - start);
  }
  std::sort(times.begin(), times.end());
  const double median = times[times.size() / 2];
  std::printf("%-34s median %7.2f ms  least %7.2f ms", name, median, times[0]);
  if (yardstick > 0) std::printf("  %.2f of Canny's", median / yardstick);
  std::printf("\n");
  return median;
}

cv::Mat Drawing() {
  Random random({.seed = 1});
  cv::Mat image(500, 960, CV_8UC3, cv::Scalar(110, 120, 130));
  for (int i = 0; i < 150; ++i) {
    const cv::Point corner(static_cast<int>(random.Index(960)),
                           static_cast<int>(random.Index(500)));
    const cv::Size size(20 + static_cast<int>(random.Index(150)),
                        20 + static_cast<int>(random.Index(150)));
    const cv::Scalar color(random.Index(256), random.Index(256), random.Index(256));
    cv::rectangle(image, {corner, size}, color, cv::FILLED);
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  for (auto& pixel : cv::Mat_<cv::Vec3b>(image)) {
    for (int c = 0; c < 3; ++c)
      pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] + 3 * random.Gaussian());
  }
  return image;
}

int Run(int argc, char** argv) {
  cv::setNumThreads(1);
  Frame frame;
  frame.image = argc > 1 ? ReadImage(argv[1], ImageKind::kColor).value() : Drawing();
  cv::resize(frame.image, frame.image, {960, 500});
  cv::Mat gray, canny;
  cv::cvtColor(frame.image, gray, cv::COLOR_BGR2GRAY);
  const double yardstick =
      Measure("Canny 20/50, 960x500", 0, [&] { cv::Canny(gray, canny, 20, 50, 3, true); });
  const auto gradient = CreateEdgeDetector("gradient", nullptr).value();
  Measure("gradient edges", yardstick, [&] { static_cast<void>(gradient->Detect(frame).value()); });
  if (argc > 2) {
    const auto network = CreateEdgeDetector(argv[2], nullptr, {.cache = false}).value();
    Measure("edge network", yardstick, [&] { static_cast<void>(network->Detect(frame).value()); });
  }
  if (argc > 3) {
    const auto detector = CreateDetector(argv[3], nullptr, {.cache = false}).value();
    Measure("detector", yardstick, [&] { static_cast<void>(detector->Detect(frame).value()); });
    const auto found = detector->Detect(frame).value();
    Random random({.seed = 2});
    std::vector<Box2> boxes;
    for (int i = 0; i < 3000; ++i) {
      const auto x = static_cast<float>(random.Uniform(0, 800)),
                 y = static_cast<float>(random.Uniform(0, 400));
      boxes.push_back({x, y, x + static_cast<float>(random.Uniform(20, 300)),
                       y + static_cast<float>(random.Uniform(20, 300))});
    }
    std::vector<float> scores(boxes.size());
    Measure("3000 boxes scored top-down", yardstick,
            [&] { found->ScoreBoxes("chair", boxes, scores); });
  }
  return 0;
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) { return plumbline::Run(argc, argv); }
