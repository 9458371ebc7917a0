// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/trajectory_alignment.h"

#include <algorithm>
#include <vector>

#include "engine/pipeline/own_pose_sequence.h"

namespace plumbline {
namespace {

/// From the sequence's world to one whose z points up, by the least turn.
Eigen::Isometry3d UprightFromWorld(const Eigen::Vector3d& gravity_in_world) {
  return Eigen::Isometry3d(
      Eigen::Quaterniond::FromTwoVectors(-gravity_in_world, Eigen::Vector3d::UnitZ()));
}

}  // namespace

Result<TrajectoryFit> AlignTrajectories(const Sequence& mapped, const Sequence& reference,
                                        const LandmarkLoops* corrected) {
  const auto mapped_gravity = mapped.gravity_in_world();
  const auto reference_gravity = reference.gravity_in_world();
  if (!mapped_gravity || !reference_gravity) {
    return Error{ErrorCode::kInvalidInput, "'" + reference.path().string() +
                                               "' has no gravity.json; trajectories are aligned "
                                               "about gravity"};
  }
  const Eigen::Isometry3d mapped_upright = UprightFromWorld(*mapped_gravity),
                          reference_upright = UprightFromWorld(*reference_gravity);
  std::vector<TimedPose> poses, references;
  const auto own_poses = OwnPosesOf(mapped);
  for (int i = 0; i < std::min(mapped.num_frames(), reference.num_frames()); ++i) {
    auto pose = own_poses != nullptr ? own_poses->LastKnown(i) : mapped.world_from_cam(i);
    const auto known = corrected != nullptr ? corrected->Known(PoseId{i}) : std::nullopt;
    if (known) pose = known->world_from_cam;
    const auto other = reference.world_from_cam(i);
    if (!pose || !other) continue;
    poses.push_back({mapped.stamp_ns(i), mapped_upright * *pose, std::nullopt});
    references.push_back({mapped.stamp_ns(i), reference_upright * *other, std::nullopt});
  }
  Result<TrajectoryErrors> errors = CompareTrajectories(poses, references, {});
  if (!errors.ok()) return errors.error();
  TrajectoryFit alignment;
  alignment.errors = std::move(errors).value();
  const Eigen::Isometry3d upright(alignment.errors.reference_from_estimate);
  alignment.reference_from_mapped = reference_upright.inverse() * upright * mapped_upright;
  return alignment;
}

}  // namespace plumbline
