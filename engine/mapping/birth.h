// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/base/random.h"
#include "engine/dataset/sequence.h"
#include "engine/mapping/particle_set.h"

namespace plumbline {

/// Box of the model's bounding box in the image, which it may exceed; nothing if a corner is behind
/// the camera's near plane.
std::optional<Box2> ProjectedBounds(const CadModel& model, const PoseHypothesis& hypothesis,
                                    const MapFrame& map, const PinholeCamera& camera,
                                    const Eigen::Isometry3d& cam_from_world);

/// The share of that box which lies inside the image; 0 if there is none.
double InsideFraction(const CadModel& model, const PoseHypothesis& hypothesis, const MapFrame& map,
                      const PinholeCamera& camera, const Eigen::Isometry3d& cam_from_world);

/// Hypotheses of a new object from an unexplained proposal, attached to the current camera, equally
/// weighted. `prior = paper`: bearing of the box centre with noise in proportion to the box,
/// log-depth nominal with noise, azimuth and label uniform. `prior = informed`: among many
/// candidates in front of the camera (on the floor where the shape stands on one), those whose
/// projection explains the box as the visible part of the object. Empty if no place explains the
/// box.
std::vector<PoseHypothesis> SampleBirth(const Detection& proposal, const PinholeCamera& camera,
                                        const Eigen::Isometry3d& world_from_cam,
                                        const MapFrame& map, const MapperOptions& options,
                                        int count, RandomKey key);

}  // namespace plumbline
