// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/mapping/map_report.h"
#include "engine/mapping/particle_set.h"

namespace plumbline {

/// The mapper's belief about one object.
struct MapObject : ObjectBelief {
  std::vector<Particle> particles;
  double seen_s = 0;  ///< Time in which it was updated.
  int last_move_frame = 0;
  std::optional<Detection> last_proposal;  ///< The last proposal it explained while tentative, and
                                           ///< where that was seen from.
  Eigen::Isometry3d world_from_proposal_cam = Eigen::Isometry3d::Identity();

  const PoseMode& mean() const { return modes.front(); }
  /// Works out modes, covariance, label and pose from the particles.
  void Summarize(const MapFrame& map);
};

ObjectReport ToReport(const MapObject& object);
/// Errors: kCorrupt.
Result<MapObject> FromReport(const ObjectReport& report);

}  // namespace plumbline
