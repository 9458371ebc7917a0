// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "engine/smoothing/contact.h"
#include "engine/smoothing/edge_claims.h"
#include "engine/smoothing/object_work.h"

namespace plumbline {

/// Refines objects by their outlines, each with the edges that the others leave it and behind what
/// they hide. Lives as long as the objects' frames and the setup that it is given.
class SceneRefiner {
 public:
  SceneRefiner(const MapperSetup& setup, const MapFrame& map, const FrameInputs& inputs)
      : setup_(setup), map_(map), inputs_(inputs) {}

  /// Of its shape at its scale; null for a model without surface.
  std::shared_ptr<const SolidModel> Solid(const PoseHypothesis& pose);
  /// The kept objects but `item`, where they stand now.
  Occluders OccludersOf(std::span<const ObjectWork> items, const ObjectWork& item);
  /// Finds which edges the kept objects explain where they stand now.
  void Claim(std::span<const ObjectWork> items);
  /// The edges of a frame that are left for an object; all before the first Claim.
  EdgeMap EdgesFor(const ObjectWork& item, int frame) const;
  /// Moves the object to where its outline lies on its edges, as far as its belief reaches. Images
  /// that do not show enough of it leave it as it is. Errors: kCancelled.
  Status Refine(ObjectWork& item, const Occluders& occluders, const std::stop_token& stop);

 private:
  const MapperSetup& setup_;
  const MapFrame& map_;
  const FrameInputs& inputs_;
  /// By label and log-scale.
  std::map<std::pair<int, double>, std::shared_ptr<const SolidModel>> solids_;
  /// By frame and object.
  std::map<int, std::map<int, std::vector<EdgeClaim>>> claims_;
};

}  // namespace plumbline
