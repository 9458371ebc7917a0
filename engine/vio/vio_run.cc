// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/vio_run.h"

#include <algorithm>
#include <cmath>

#include "engine/base/random.h"

namespace plumbline {
namespace {

/// The IMU is fed this far beyond an image: the offset of the clocks may grow.
constexpr std::int64_t kImuMarginNs = 50'000'000;

}  // namespace

VioRun RunVio(const VioInput& input, const VioOptions& options) {
  VioEstimator estimator(input.camera, input.imu, options);
  if (input.start) estimator.StartFrom(*input.start);
  VioRun run;
  const auto take_points = [&] {
    for (MapPoint& point : estimator.TakePoints()) run.points.push_back(point);
  };
  std::size_t next = 0;
  for (const TrackedImage& image : input.images) {
    const std::int64_t until =
        image.stamp_ns + kImuMarginNs + std::llround(input.imu.time_offset_s * 1e9);
    while (next < input.samples.size() && input.samples[next].stamp_ns <= until)
      estimator.AddImu(input.samples[next++]);
    if (auto report = estimator.AddImage(image)) run.reports.push_back(std::move(*report));
    take_points();
  }
  return run;
}

std::vector<TrackedImage> DropTracks(std::span<const TrackedImage> images, double probability,
                                     std::uint64_t seed) {
  std::vector<TrackedImage> kept(images.begin(), images.end());
  for (TrackedImage& image : kept) {
    std::erase_if(image.points, [&](const TrackedPoint& point) {
      const auto id = static_cast<std::uint64_t>(point.id);
      return Random({seed, static_cast<std::uint32_t>(id), static_cast<std::uint32_t>(id >> 32)})
                 .Uniform() < probability;
    });
  }
  return kept;
}

}  // namespace plumbline
