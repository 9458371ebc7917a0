// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include <Eigen/Geometry>

#include "tests/support/annotation_scene.h"

namespace plumbline {

/// Writes a sequence that belongs to a scene: a camera walks round its armchair, whose outline it
/// sees as perfect edges.
///
/// @param world_from_scan  Of the sequence, if it has a frame of its own.
void WriteAnnotationWalk(const AnnotationScene& scene, const std::filesystem::path& folder,
                         const Eigen::Isometry3d& world_from_scan = Eigen::Isometry3d::Identity());

}  // namespace plumbline
