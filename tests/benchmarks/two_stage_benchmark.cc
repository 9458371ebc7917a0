// SPDX-License-Identifier: Apache-2.0
// What the two stages cost on one and two threads:
//   two_stage_benchmark FILE.onnx [IMAGE]
// Wall time, the least of several runs: on a busy machine the nearest to what the work itself
// takes.

#include <algorithm>
#include <cstdio>
#include <functional>
#include <vector>

#include <opencv2/core/utility.hpp>

#include "engine/base/random.h"
#include "engine/base/timer.h"
#include "engine/sensor/image_file.h"
#include "engine/vision/detector.h"
#include "engine/vision/two_stage_network.h"

namespace plumbline {
namespace {

double LeastMilliseconds(int runs, const std::function<void()>& run) {
  double least = 1e9;
  for (int i = 0; i < runs; ++i) {
    Stopwatch watch;
    run();
    least = std::min(least, watch.Lap());
  }
  return least;
}

std::vector<Box2> BoxesIn(const cv::Size& size, int count) {
  Random random({.seed = 2});
  std::vector<Box2> boxes;
  for (int i = 0; i < count; ++i) {
    const auto width = static_cast<float>(random.Uniform(16, size.width / 2)),
               height = static_cast<float>(random.Uniform(16, size.height / 2));
    const auto x = static_cast<float>(random.Uniform(0, size.width / 2)),
               y = static_cast<float>(random.Uniform(0, size.height / 2));
    boxes.push_back({x, y, x + width, y + height});
  }
  return boxes;
}

int Run(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "two_stage_benchmark FILE.onnx [IMAGE]\n");
    return 2;
  }
  const auto network = TwoStageNetwork::Load(argv[1], ReadNetworkSidecar(argv[1]).value()).value();
  const cv::Size size(network->sidecar().width, network->sidecar().height);
  cv::Mat image(480, 640, CV_8UC3);
  cv::RNG(1).fill(image, cv::RNG::UNIFORM, 0, 256);
  if (argc > 2) image = ReadImage(argv[2], ImageKind::kColor).value();
  const FittedImage fitted = FitImage(image, network->sidecar());
  for (const int threads : {1, 2}) {
    cv::setNumThreads(threads);
    std::vector<cv::Mat> levels;
    std::printf("%d threads: trunk %.1f ms", threads,
                LeastMilliseconds(15, [&] { levels = network->RunTrunk(fitted).value(); }));
    const auto proposals = network->Propose(levels, fitted);
    std::printf(", %zu regions %.2f ms", proposals.size(), LeastMilliseconds(15, [&] {
                  static_cast<void>(network->Propose(levels, fitted));
                }));
    const auto features = network->Features(levels);
    std::printf("; boxes: crops, crops and head [ms]:");
    for (const int count : {100, 300, 1000, 2500}) {
      const std::vector<Box2> boxes = BoxesIn(size, count);
      const double crops = LeastMilliseconds(5, [&] {
        for (std::size_t i = 0; i < boxes.size(); i += 128) {
          const auto batch =
              std::span(boxes).subspan(i, std::min<std::size_t>(128, boxes.size() - i));
          static_cast<void>(CropRegions(features, batch, static_cast<int>(batch.size()),
                                        network->sidecar().two_stage));
        }
      });
      std::printf("  %d: %.1f, %.1f", count, crops, LeastMilliseconds(5, [&] {
                    static_cast<void>(network->RunHead(features, boxes).value());
                  }));
    }
    std::printf("\n");
  }
  // Another category of boxes that were scored already.
  Frame frame;
  frame.image = image;
  const auto detector = CreateDetector(argv[1], nullptr, {.cache = false}).value();
  const auto found = detector->Detect(frame).value();
  const std::vector<Box2> boxes = BoxesIn(image.size(), 2500);
  std::vector<float> scores(boxes.size());
  const auto& categories = network->sidecar().categories;
  found->ScoreBoxes(categories.front(), boxes, scores);
  std::printf("2500 boxes again, as another category: %.2f ms\n",
              LeastMilliseconds(15, [&] { found->ScoreBoxes(categories.back(), boxes, scores); }));
  return 0;
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) { return plumbline::Run(argc, argv); }
