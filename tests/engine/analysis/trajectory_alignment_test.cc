// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/trajectory_alignment.h"

#include <gtest/gtest.h>

#include "engine/pipeline/own_pose_sequence.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

TEST(AlignTrajectories, FindsHeadingAndPositionFromTheFramesWithPoses) {
  const TemporaryFolder folder;
  WriteTinySequence(folder.path() / "sequence", {.frames = 8});
  const auto given = OpenSequence(folder.path() / "sequence").value();
  const Eigen::Isometry3d own_from_given =
      Eigen::Translation3d(1, -2, 0.5) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
  auto poses = std::make_shared<OwnPoses>();
  poses->frames.resize(8);
  for (int i = 2; i < 8; ++i) {
    OwnPoseReport& frame = poses->frames[static_cast<std::size_t>(i)];
    frame.ready = true;
    frame.world_from_cam = own_from_given * *given->world_from_cam(i);
  }
  const auto alignment = AlignTrajectories(*WithOwnPoses(given, poses), *given);
  ASSERT_TRUE(alignment.ok()) << alignment.error().message;
  EXPECT_EQ(alignment->errors.matched, 6);
  EXPECT_LT(alignment->errors.ate_m, 1e-9);
  EXPECT_TRUE(alignment->reference_from_mapped.isApprox(own_from_given.inverse(), 1e-9));

  poses = std::make_shared<OwnPoses>(*poses);
  for (std::size_t i = 4; i < 8; ++i) poses->frames[i].ready = false;
  EXPECT_EQ(AlignTrajectories(*WithOwnPoses(given, poses), *given).error().code,
            ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace plumbline
