// SPDX-License-Identifier: Apache-2.0
// Loops of a simulated recording that comes back to where it was, through the poses that a mapper gets.
#include "engine/vio/loop_closer.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/vio/own_poses.h"
#include "tests/support/simulated_sequence.h"

namespace plumbline {
namespace {

constexpr double kRound_s = 20 * M_PI;  ///< Of the simulator's motion.
constexpr double kHz = 10;

class LoopCloserTest : public testing::Test {
 protected:
  static OwnPoses Estimate(LoopUse loops, double seconds = kRound_s + 8) {
    const auto sequence =
        SimulatedSequence(Simulate({.seconds = seconds, .room_points = 420, .follow_all = true,
                                    .image_hz = kHz, .pixel_noise_px = 0, .imu_noise = 3}));
    OwnPoseOptions options;
    options.loops = loops;
    auto poses = EstimateOwnPoses(*sequence, sequence->num_frames(), options, {});
    EXPECT_TRUE(poses.ok()) << (poses.ok() ? "" : poses.error().message);
    return poses.ok() ? std::move(poses).value() : OwnPoses();
  }

  /// How far a frame of the second round stands from where the first round had it; its place in the
  /// simulation is the same to 2 mm.
  static double ReturnError(const OwnPoses& poses, int frame) {
    const int again = frame + static_cast<int>(std::lround(kRound_s * kHz));
    return (poses.frames[static_cast<std::size_t>(again)].world_from_cam->translation() -
            poses.frames[static_cast<std::size_t>(frame)].world_from_cam->translation())
        .norm();
  }
};

TEST_F(LoopCloserTest, ARoundEndsWhereItBegan) {
  const OwnPoses off = Estimate(LoopUse::kOff), corrected = Estimate(LoopUse::kCorrected);
  EXPECT_TRUE(off.causal);
  EXPECT_EQ(off.loops.key_frames, 0);
  EXPECT_FALSE(corrected.causal);
  ASSERT_GT(corrected.loops.believed(), 0);
  EXPECT_EQ(corrected.loops.believed(), static_cast<int>(corrected.loops.closures.size()));
  for (const LoopClosure& closure : corrected.loops.closures)
    EXPECT_GT(closure.image - closure.old_image, 10 * kHz);
  const double before = ReturnError(off, 60), after = ReturnError(corrected, 60);
  std::printf("a frame seen again: %.3f m off without loops, %.3f m with %d\n", before, after,
              corrected.loops.believed());
  EXPECT_LT(after, 0.5 * before);
  EXPECT_LT(after, 0.04);
  EXPECT_EQ(corrected.EpochAt(0), corrected.loops.epochs);
}

TEST_F(LoopCloserTest, CausalPosesKnowOfNoLaterImage) {
  const OwnPoses off = Estimate(LoopUse::kOff), causal = Estimate(LoopUse::kCausal);
  EXPECT_TRUE(causal.causal);
  ASSERT_FALSE(causal.loops.closures.empty());
  const int first = causal.loops.closures.front().closed_image;
  for (int i = 0; i < first; ++i) {
    const auto at = static_cast<std::size_t>(i);
    EXPECT_EQ(causal.EpochAt(i), 0);
    ASSERT_EQ(causal.frames[at].world_from_cam.has_value(), off.frames[at].world_from_cam.has_value());
    if (off.frames[at].world_from_cam) {
      EXPECT_EQ(causal.frames[at].world_from_cam->matrix(), off.frames[at].world_from_cam->matrix());
    }
  }
  EXPECT_EQ(causal.EpochAt(first), 1);
  EXPECT_LT(ReturnError(causal, 60), 0.5 * ReturnError(off, 60));
}

TEST_F(LoopCloserTest, WithoutAReturnNothingChanges) {
  const OwnPoses off = Estimate(LoopUse::kOff, 8), corrected = Estimate(LoopUse::kCorrected, 8);
  EXPECT_TRUE(corrected.causal);
  EXPECT_TRUE(corrected.loops.closures.empty());
  EXPECT_GT(corrected.loops.key_frames, 3);
  for (std::size_t i = 0; i < off.frames.size(); ++i) {
    if (!off.frames[i].world_from_cam) continue;
    EXPECT_EQ(corrected.frames[i].world_from_cam->matrix(), off.frames[i].world_from_cam->matrix());
    EXPECT_EQ(corrected.frames[i].cam_covariance, off.frames[i].cam_covariance);
  }
}

}  // namespace
}  // namespace plumbline
