// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/past_correction.h"

#include <algorithm>

namespace plumbline {

Eigen::Isometry3d CorrectedBy(const PastCorrection& correction, std::span<const PastCorrection> all,
                              const PoseWhenTold& told) {
  const auto later =
      std::upper_bound(all.begin(), all.end(), told.image,
                       [](int image, const PastCorrection& known) { return image < known.image; });
  if (later == all.begin()) {  // the filter's own
    return correction.past.At(told.stamp_ns, told.body_in_world) * told.world_from_cam;
  }
  const Eigen::Isometry3d filter_from_told = (later - 1)->present.AsIsometry().inverse();
  return correction.past.At(told.stamp_ns, filter_from_told * told.body_in_world) *
         filter_from_told * told.world_from_cam;
}

}  // namespace plumbline
