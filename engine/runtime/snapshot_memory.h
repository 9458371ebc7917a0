// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <unordered_map>

namespace plumbline {

struct MapSnapshot;

/// The snapshots that were used last, within a budget of bytes, by position.
class SnapshotMemory {
 public:
  explicit SnapshotMemory(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}

  void Put(int position, std::shared_ptr<const MapSnapshot> snapshot);
  /// Null if it is forgotten.
  std::shared_ptr<const MapSnapshot> Get(int position);
  std::size_t bytes() const { return bytes_; }
  std::size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    int position;
    std::size_t bytes;
    std::shared_ptr<const MapSnapshot> snapshot;
  };
  std::size_t budget_bytes_;
  std::size_t bytes_ = 0;
  std::list<Entry> entries_;  ///< Last used first.
  std::unordered_map<int, std::list<Entry>::iterator> by_position_;
};

/// What a snapshot keeps in memory, about.
std::size_t BytesOf(const MapSnapshot& snapshot);

}  // namespace plumbline
