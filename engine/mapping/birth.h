// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/base/random.h"
#include "engine/dataset/sequence.h"
#include "engine/mapping/particle_set.h"

namespace plumbline {

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
