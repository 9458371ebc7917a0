// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/rest_detector.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <vector>

namespace plumbline {
namespace {

constexpr std::size_t kMinCommon = 8;
constexpr int kMinPlaces = 5;
/// Median over mean of the square of a length whose two axes are normal: ln 2.
constexpr double kMedianOfSquare = 0.693;

/// Where a point was on average, and what it jumps by from image to image.
struct MeanPlace {
  Eigen::Vector2d sum{0, 0}, last{0, 0};
  double jumps = 0;  ///< Sum of squared steps [px^2].
  int count = 0;

  Eigen::Vector2d mean() const { return sum / count; }
  /// Variance of the mean, both axes together, by the noise of single places: half the mean square
  /// of a step is the variance of a place. 0 where there are too few to tell noise from a slow
  /// motion, whose steps are as large.
  double variance() const { return count >= kMinPlaces ? 0.5 * jumps / (count - 1) / count : 0; }
};
using MeanPlaces = std::unordered_map<std::int64_t, MeanPlace>;

void AddPlaces(const TrackedImage& image, MeanPlaces& places) {
  for (const TrackedPoint& point : image.points) {
    MeanPlace& place = places[point.id];
    if (place.count > 0) place.jumps += (point.pixel - place.last).squaredNorm();
    place.sum += point.pixel;
    place.last = point.pixel;
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
  std::vector<double> wander;  // squared, less what noise explains
  for (const TrackedPoint& point : images_.back().points) {
    const auto before = first.find(point.id);
    if (before == first.end()) continue;
    const MeanPlace& now = second[point.id];
    wander.push_back((now.mean() - before->second.mean()).squaredNorm() -
                     kMedianOfSquare * (now.variance() + before->second.variance()));
  }
  if (wander.size() < kMinCommon) return std::nullopt;
  const auto half = wander.begin() + static_cast<std::ptrdiff_t>(wander.size() / 2);
  std::nth_element(wander.begin(), half, wander.end());
  return std::sqrt(std::max(*half, 0.0));
}

}  // namespace plumbline
