// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/rest_detector.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

namespace plumbline {
namespace {

constexpr std::size_t kMinCommon = 8;

/// Where a point was on average.
struct MeanPlace {
  Eigen::Vector2d sum{0, 0};
  int count = 0;
};
using MeanPlaces = std::unordered_map<std::int64_t, MeanPlace>;

void AddPlaces(const TrackedImage& image, MeanPlaces& places) {
  for (const TrackedPoint& point : image.points) {
    MeanPlace& place = places[point.id];
    place.sum += point.pixel;
    ++place.count;
  }
}

}  // namespace

void RestDetector::Add(const TrackedImage& image) {
  images_.push_back(image);
  while (images_.size() > 2 && images_[1].stamp_ns < image.stamp_ns - memory_ns_)
    images_.pop_front();
}

std::optional<double> RestDetector::WanderWithin(double seconds) const {
  if (images_.empty()) return std::nullopt;
  const auto span = static_cast<std::int64_t>(seconds * 1e9);
  const std::int64_t begin = images_.back().stamp_ns - span, middle = begin + span / 2;
  if (images_.front().stamp_ns > begin) return std::nullopt;
  MeanPlaces first, second;
  for (const TrackedImage& image : images_) {
    if (image.stamp_ns < begin) continue;
    AddPlaces(image, image.stamp_ns < middle ? first : second);
  }
  std::vector<double> wander;
  for (const TrackedPoint& point : images_.back().points) {
    const auto before = first.find(point.id);
    if (before == first.end()) continue;
    const MeanPlace& now = second[point.id];
    wander.push_back((now.sum / now.count - before->second.sum / before->second.count).norm());
  }
  if (wander.size() < kMinCommon) return std::nullopt;
  const auto half = wander.begin() + static_cast<std::ptrdiff_t>(wander.size() / 2);
  std::nth_element(wander.begin(), half, wander.end());
  return *half;
}

}  // namespace plumbline
