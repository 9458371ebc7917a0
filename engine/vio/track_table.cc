// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/track_table.h"

#include <algorithm>
#include <array>

namespace plumbline {
namespace {

constexpr int kCells = 8;  ///< Along each side of the image.

}  // namespace

TrackTable::TrackTable(const Camera& camera, int max_tracks)
    : camera_(camera),
      width_(camera.pinhole.width),
      height_(camera.pinhole.height),
      max_tracks_(max_tracks) {}

void TrackTable::AddPoint(const TrackedPoint& point, std::int64_t clone) {
  const auto ray = camera_.Unproject(point.pixel);
  if (!ray) return;
  Track& track = tracks_[point.id];
  track.observations.push_back({clone, point.pixel, *ray});
  ++track.age;
  track.seen = true;
}

void TrackTable::Add(const TrackedImage& image, std::int64_t clone,
                     const std::map<std::int64_t, int>& kept) {
  for (auto& [id, track] : tracks_) track.seen = false;
  std::array<int, kCells * kCells> crowd{};
  const auto cell = [&](const Eigen::Vector2d& pixel) {
    const int x = std::clamp(static_cast<int>(kCells * pixel.x() / width_), 0, kCells - 1);
    const int y = std::clamp(static_cast<int>(kCells * pixel.y() / height_), 0, kCells - 1);
    return static_cast<std::size_t>(y * kCells + x);
  };
  std::array<std::vector<const TrackedPoint*>, kCells * kCells> fresh;
  int count = 0;
  for (const TrackedPoint& point : image.points) {
    const bool known = tracks_.count(point.id) > 0;
    if (known) AddPoint(point, clone);
    if (known || kept.count(point.id) > 0) {
      ++crowd[cell(point.pixel)];
      ++count;
    } else {
      fresh[cell(point.pixel)].push_back(&point);
    }
  }
  // New tracks where there are fewest, a round at a time.
  for (int level = 0; count < max_tracks_; ++level) {
    bool any = false;
    for (std::size_t c = 0; c < fresh.size() && count < max_tracks_; ++c) {
      any = any || !fresh[c].empty();
      if (fresh[c].empty() || crowd[c] > level) continue;
      AddPoint(*fresh[c].front(), clone);
      fresh[c].erase(fresh[c].begin());
      ++crowd[c];
      ++count;
    }
    if (!any) break;
  }
}

void TrackTable::ForgetClone(std::int64_t clone) {
  for (auto entry = tracks_.begin(); entry != tracks_.end();) {
    std::erase_if(entry->second.observations,
                  [&](const Observation& o) { return o.clone == clone; });
    entry = entry->second.observations.empty() && !entry->second.seen ? tracks_.erase(entry)
                                                                      : std::next(entry);
  }
}

}  // namespace plumbline
