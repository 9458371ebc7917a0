// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/snapshot_memory.h"

#include <utility>

#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

std::size_t BytesOf(const MapSnapshot& snapshot) {
  std::size_t bytes = sizeof(MapSnapshot) + snapshot.report.mapper_state.size();
  for (const cv::Mat* mat : {&snapshot.image, &snapshot.edge_probability, &snapshot.edge_angle,
                             &snapshot.depth, &snapshot.id}) {
    bytes += mat->total() * mat->elemSize();
  }
  for (const ObjectReport& object : snapshot.report.objects) {
    bytes += sizeof(ObjectReport) + object.filter_state.size();
    if (object.particles != nullptr) bytes += object.particles->size() * sizeof(Particle);
  }
  return bytes;
}

void SnapshotMemory::Put(int position, std::shared_ptr<const MapSnapshot> snapshot) {
  if (const auto found = by_position_.find(position); found != by_position_.end()) {
    bytes_ -= found->second->bytes;
    entries_.erase(found->second);
    by_position_.erase(found);
  }
  const std::size_t bytes = BytesOf(*snapshot);
  entries_.push_front({position, bytes, std::move(snapshot)});
  by_position_[position] = entries_.begin();
  bytes_ += bytes;
  while (bytes_ > budget_bytes_ && entries_.size() > 1) {
    bytes_ -= entries_.back().bytes;
    by_position_.erase(entries_.back().position);
    entries_.pop_back();
  }
}

std::shared_ptr<const MapSnapshot> SnapshotMemory::Get(int position) {
  const auto found = by_position_.find(position);
  if (found == by_position_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, found->second);
  return found->second->snapshot;
}

}  // namespace plumbline
