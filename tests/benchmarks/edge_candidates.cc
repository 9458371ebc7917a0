// SPDX-License-Identifier: Apache-2.0
// Writes what the gradient edge detector knows about its candidates, for
// assets/networks/gradient_edges/train.py:
//   edge_candidates NOISE OUT IMAGE...
// For each image an int32 count, then per candidate ten float32: x, y and the features.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "engine/base/random.h"
#include "engine/sensor/image_file.h"
#include "engine/vision/edge_gradient.h"

int main(int argc, char** argv) {
  using namespace plumbline;
  if (argc < 4) {
    std::fprintf(stderr, "usage: edge_candidates NOISE OUT IMAGE...\n");
    return 2;
  }
  const double noise = std::atof(argv[1]);
  std::ofstream out(argv[2], std::ios::binary);
  EdgeCandidateFinder finder;
  for (int i = 3; i < argc; ++i) {
    const Result<cv::Mat> read = ReadImage(argv[i], ImageKind::kColor);
    if (!read.ok()) {
      std::fprintf(stderr, "%s\n", read.error().message.c_str());
      return 1;
    }
    cv::Mat image = read.value().clone();
    Random random({.seed = static_cast<std::uint64_t>(i)});
    for (auto& pixel : cv::Mat_<cv::Vec3b>(image)) {
      for (int c = 0; noise > 0 && c < 3; ++c) {
        pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] + noise * random.Gaussian());
      }
    }
    const auto& candidates = finder.Find(image);
    const auto count = static_cast<std::int32_t>(candidates.size());
    out.write(reinterpret_cast<const char*>(&count), sizeof(count));
    for (const EdgeCandidate& candidate : candidates) {
      const float place[2] = {static_cast<float>(candidate.x), static_cast<float>(candidate.y)};
      out.write(reinterpret_cast<const char*>(place), sizeof(place));
      out.write(reinterpret_cast<const char*>(candidate.features.data()),
                sizeof(candidate.features));
    }
  }
  return out.good() ? 0 : 1;
}
