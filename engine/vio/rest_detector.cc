// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/rest_detector.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

namespace plumbline {
namespace {

constexpr std::size_t kMinCommon = 8;

std::optional<double> MedianMotion(const TrackedImage& from, const TrackedImage& to) {
  std::unordered_map<std::int64_t, Eigen::Vector2d> before;
  for (const TrackedPoint& point : from.points) before.emplace(point.id, point.pixel);
  std::vector<double> motion;
  for (const TrackedPoint& point : to.points) {
    const auto found = before.find(point.id);
    if (found != before.end()) motion.push_back((point.pixel - found->second).norm());
  }
  if (motion.size() < kMinCommon) return std::nullopt;
  const auto middle = motion.begin() + static_cast<std::ptrdiff_t>(motion.size() / 2);
  std::nth_element(motion.begin(), middle, motion.end());
  return *middle;
}

}  // namespace

void RestDetector::Add(const TrackedImage& image) {
  images_.push_back(image);
  while (images_.size() > 2 && images_[1].stamp_ns < image.stamp_ns - memory_ns_)
    images_.pop_front();
}

std::optional<double> RestDetector::MotionSince(double seconds) const {
  if (images_.empty()) return std::nullopt;
  const std::int64_t latest = images_.back().stamp_ns - static_cast<std::int64_t>(seconds * 1e9);
  for (auto image = images_.rbegin(); image != images_.rend(); ++image) {
    if (image->stamp_ns <= latest) return MedianMotion(*image, images_.back());
  }
  return std::nullopt;
}

std::optional<double> RestDetector::MostMotionWithin(double seconds) const {
  if (images_.empty()) return std::nullopt;
  const std::int64_t latest = images_.back().stamp_ns - static_cast<std::int64_t>(seconds * 1e9);
  double most = 0;
  for (auto image = images_.rbegin(); image != images_.rend(); ++image) {
    const auto motion = MedianMotion(*image, images_.back());
    if (!motion) return std::nullopt;
    most = std::max(most, *motion);
    if (image->stamp_ns <= latest) return most;
  }
  return std::nullopt;
}

}  // namespace plumbline
