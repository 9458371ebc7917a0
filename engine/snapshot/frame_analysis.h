// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/base/ids.h"
#include "engine/snapshot/object_relation.h"

namespace plumbline {

struct MapSnapshot;

/// What is worked out of a frame besides what the mapper says, where somebody shows it.
struct FrameAnalysis {
  std::shared_ptr<const MapSnapshot> frame;  ///< Never null.
  /// How its objects stand to one another; nothing: nobody asked.
  std::optional<std::vector<ObjectRelation>> relations;
  ObjectId object;           ///< The one that is watched.
  std::vector<int> by_rank;  ///< Indices of its particles, the best first.
};

}  // namespace plumbline
