// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"
#include "engine/evaluation/trajectory_error.h"
#include "engine/vio/landmark_loops.h"

namespace plumbline {

/// How the poses that a run was made with lie to those of a reference, by the trajectories alone.
struct TrajectoryFit {
  /// Turns about gravity and moves; both worlds' gravity is brought together exactly.
  Eigen::Isometry3d reference_from_mapped = Eigen::Isometry3d::Identity();
  TrajectoryErrors errors;  ///< After the alignment.
};

/// Aligns the cameras of the frames that have a pose in both, in heading and position.
/// @param mapped  With the poses of the run: OpenSequenceOfRun.
/// @param reference  The same frames with other poses.
/// @param corrected  What corrected poses while the run mapped; null: nothing.
/// Errors: kDegenerate for fewer than 3 such frames; kInvalidInput without gravity.
Result<TrajectoryFit> AlignTrajectories(const Sequence& mapped, const Sequence& reference,
                                        const LandmarkLoops* corrected = nullptr);

}  // namespace plumbline
