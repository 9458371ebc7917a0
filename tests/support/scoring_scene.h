// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// One object in one image with the edges that are found of it, in a world whose z is
/// up and whose floor is z = 0.
struct ScoringScene {
  PinholeCamera camera;
  Eigen::Isometry3d cam_from_world = Eigen::Isometry3d::Identity();
  PoseHypothesis truth;
  std::unique_ptr<OrientedTable> table;
  cv::Mat occluder_depth;  ///< Empty, or a board in front of a part of the object.

  ScoringView View() const;
};

/// The object 2 to 3 m in front of a camera at eye height, photographed by rays with clutter and
/// noise, and the gradient edges of that picture; every other seed hides a part of it.
ScoringScene MakeScoringScene(const ModelDatabase& database, ModelId model,
                              const PinholeCamera& camera, std::uint64_t seed);

Eigen::Isometry3d CamFromObject(const ScoringScene& scene, const ModelDatabase& database,
                                const PoseHypothesis& hypothesis);

/// Hypotheses around the truth: Gaussian in each coordinate and in azimuth.
std::vector<PoseHypothesis> Scattered(const ScoringScene& scene, int count, double position_m,
                                      double angle_deg, std::uint64_t seed);

/// Rank correlation of two lists of the same length.
double Spearman(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace plumbline
