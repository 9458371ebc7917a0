// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/progress.h"
#include "engine/mapping/map_object.h"
#include "engine/mapping/mapper.h"
#include "engine/smoothing/looks.h"

namespace plumbline {

/// What all looks together say of whether an object is there.
struct Presence {
  double log_odds = 0;      ///< Of being there.
  double shown = 0;         ///< Independent looks in which enough of it showed, see confirm_shown.
  std::vector<int> frames;  ///< Of the looks that show it.
  std::vector<int> same_view;  ///< For each object, looks in which both explain one part of the
                               ///< image.
};

/// Inputs of a frame, computed again.
using LoadFrame = std::function<Result<MapperInput>(int frame)>;

/// Looks at every object in all frames chosen, before and after it was found, with the filter's
/// measure of being there. What settled objects gain over their surroundings, over the whole
/// recording, is the measure of what others gain. Looks that cannot be read again are left out.
/// Errors: kCancelled.
Result<std::vector<Presence>> LookBack(const MapperSetup& setup, OcclusionRenderer& renderer,
                                       std::span<const Look> looks,
                                       std::span<const MapObject> objects, const LoadFrame& load,
                                       const WorkContext& work);

}  // namespace plumbline
