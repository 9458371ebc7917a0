// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/mapping/map_report.h"
#include "engine/mapping/particle_set.h"

namespace plumbline {

/// The mapper's belief about one object.
struct MapObject {
  ObjectId id;
  ObjectState state = ObjectState::kTentative;
  std::string category;
  int reference_frame = 0;
  Eigen::Isometry3d world_from_reference_cam = Eigen::Isometry3d::Identity();
  int first_frame = 0;
  std::optional<int> confirmed_frame;
  int last_frame = 0;
  std::vector<Particle> particles;

  double log_evidence = 0;
  double seen_s = 0;  ///< Time in which it was weighed.
  int last_move_frame = 0;
  std::optional<Detection> last_proposal;  ///< The last proposal it explained while tentative, and
                                           ///< where that was seen from.
  Eigen::Isometry3d world_from_proposal_cam = Eigen::Isometry3d::Identity();

  // Derived from the particles by Summarize.
  std::vector<PoseMode> modes;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  std::vector<LabelProbability> label_probability;

  // Of the last frame, for the report.
  bool weighed = false;
  double visible_fraction = 0;
  double effective_sample_size = 0;
  float phi_cnn = 0, phi_edge = 0;
  Box2 whole_box, visible_box;

  const PoseMode& mean() const { return modes.front(); }
  void Summarize(const MapFrame& map);
};

ObjectReport ToReport(const MapObject& object);
/// Errors: kCorrupt.
Result<MapObject> FromReport(const ObjectReport& report);

}  // namespace plumbline
