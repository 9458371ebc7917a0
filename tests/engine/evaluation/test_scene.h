// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/evaluation/map_evaluation.h"

namespace plumbline {

/// Box with its footprint's centre at the origin, `n` x `n` squares on each side.
TriangleMesh BoxMesh(double x, double y, double z, int n = 4);

/// chair, stool (category chair), table (180 degrees symmetric), mug and bowl (category cup,
/// continuous).
std::shared_ptr<const ModelDatabase> TestDatabase();

/// Upright in a z-up world.
Eigen::Isometry3d UprightPose(double x, double y, double z, double azimuth_deg);

/// Three chairs, a table and a mug; the mug and one chair coarse.
GroundTruth TestTruth();

/// A map without errors; ids 1, 2, ...
std::vector<EstimatedObject> PerfectMap(const GroundTruth& truth);

}  // namespace plumbline
