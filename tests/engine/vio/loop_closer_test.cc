// SPDX-License-Identifier: Apache-2.0
// Loops of a simulated recording that comes back to where it was, through the poses that a mapper
// gets.
#include "engine/vio/loop_closer.h"

#include <algorithm>
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
  static std::shared_ptr<const Sequence> Film(double seconds) {
    return SimulatedSequence(Simulate({.seconds = seconds,
                                       .room_points = 420,
                                       .follow_all = true,
                                       .image_hz = kHz,
                                       .pixel_noise_px = 0,
                                       .imu_noise = 3}));
  }
  static OwnPoses Estimate(LoopUse loops, const std::shared_ptr<const Sequence>& sequence) {
    OwnPoseOptions options;
    options.loops = loops;
    auto poses = EstimateOwnPoses(sequence, sequence->num_frames(), options, {});
    EXPECT_TRUE(poses.ok()) << (poses.ok() ? "" : poses.error().message);
    return poses.ok() ? std::move(poses).value() : OwnPoses();
  }
  static void SetUpTestSuite() {
    round_ = Film(kRound_s + 8);
    off_ = Estimate(LoopUse::kOff, round_);
  }
  static void TearDownTestSuite() { round_.reset(); }

  /// How far a frame of the second round stands from where it should, as the first round has it.
  static double ReturnError(const OwnPoses& poses) {
    const int frame = 60, again = frame + static_cast<int>(std::lround(kRound_s * kHz));
    const auto pose = [&](int i) {
      return *poses.frames[static_cast<std::size_t>(i)].world_from_cam;
    };
    const Eigen::Isometry3d truth =
        round_->world_from_cam(frame)->inverse() * *round_->world_from_cam(again);
    return ((pose(frame).inverse() * pose(again)).translation() - truth.translation()).norm();
  }

  static std::shared_ptr<const Sequence> round_;
  static OwnPoses off_;
};

std::shared_ptr<const Sequence> LoopCloserTest::round_;
OwnPoses LoopCloserTest::off_;

TEST_F(LoopCloserTest, ARoundEndsWhereItBegan) {
  const OwnPoses corrected = Estimate(LoopUse::kCorrected, round_);
  EXPECT_TRUE(off_.causal);
  EXPECT_EQ(off_.loops.key_frames, 0);
  EXPECT_FALSE(corrected.causal);
  ASSERT_GT(corrected.loops.believed(), 0);
  EXPECT_EQ(corrected.loops.believed(), static_cast<int>(corrected.loops.closures.size()));
  for (const LoopClosure& closure : corrected.loops.closures)
    EXPECT_GT(closure.image - closure.old_image, 10 * kHz);
  const double before = ReturnError(off_), after = ReturnError(corrected);
  std::printf("a frame seen again: %.3f m off without loops, %.3f m with %d\n", before, after,
              corrected.loops.believed());
  EXPECT_LT(after, 0.5 * before);
  EXPECT_LT(after, 0.04);
  EXPECT_EQ(corrected.EpochAt(0), corrected.loops.epochs);
}

TEST_F(LoopCloserTest, AClosedLoopLeavesTheHeightAsSureAsTheFilterHasIt) {
  const OwnPoses corrected = Estimate(LoopUse::kCorrected, round_);
  ASSERT_GT(corrected.loops.believed(), 0);
  double of_filter = 0, told = 0;
  for (std::size_t i = 0; i < off_.frames.size(); ++i) {
    if (!off_.frames[i].world_from_cam) continue;
    of_filter = std::max(of_filter, std::sqrt(off_.frames[i].cam_covariance(2, 2)));
    told = std::max(told, std::sqrt(corrected.frames[i].cam_covariance(2, 2)));
  }
  std::printf("height told to at most %.3f m, by the filter %.3f m\n", told, of_filter);
  EXPECT_LT(told, 1.5 * of_filter) << "what is unsure of gravity at first tilts nothing later";
}

TEST_F(LoopCloserTest, CausalPosesKnowOfNoLaterImage) {
  const OwnPoses causal = Estimate(LoopUse::kCausal, round_);
  EXPECT_TRUE(causal.causal);
  ASSERT_FALSE(causal.loops.closures.empty());
  const int first = causal.loops.closures.front().closed_image;
  for (int i = 0; i < first; ++i) {
    const auto at = static_cast<std::size_t>(i);
    EXPECT_EQ(causal.EpochAt(i), 0);
    const auto &pose = causal.frames[at].world_from_cam,
               &by_filter = off_.frames[at].world_from_cam;
    ASSERT_EQ(pose.has_value(), by_filter.has_value());
    if (pose) {
      EXPECT_EQ(pose->matrix(), by_filter->matrix());
    }
  }
  EXPECT_EQ(causal.EpochAt(first), 1);
  EXPECT_LT(ReturnError(causal), 0.75 * ReturnError(off_));
}

TEST_F(LoopCloserTest, OfManyKeyFramesThoseNearAnOlderOneAreLetGoOf) {
  OwnPoseOptions options;
  options.loops = LoopUse::kCausal;
  const auto run = [&](int kept) {
    options.closing.key_frames_kept = kept;
    return EstimateOwnPoses(round_, round_->num_frames(), options, {}).value().loops;
  };
  const LoopReport all = run(1000), few = run(60);
  EXPECT_EQ(all.key_frames, few.key_frames);
  ASSERT_GT(all.key_frames, 120);
  std::printf("%d key frames, %.1f MB, %d closures; of 60 to 66 kept %.1f MB, %d closures\n",
              all.key_frames, all.bytes / 1e6, all.believed(), few.bytes / 1e6, few.believed());
  EXPECT_LT(few.bytes, 0.7 * all.bytes);
  EXPECT_GT(few.believed(), 0) << "the place is known again by the others";
}

TEST_F(LoopCloserTest, WithoutAReturnNothingChanges) {
  const auto sequence = Film(8);
  const OwnPoses off = Estimate(LoopUse::kOff, sequence),
                 corrected = Estimate(LoopUse::kCorrected, sequence);
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
