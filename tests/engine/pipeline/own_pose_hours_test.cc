// SPDX-License-Identifier: Apache-2.0
// Slow. What a live run with poses of its own costs as it goes on: somebody walks round and round
// in a simulated room, and comes back to where he was all the time. PLUMBLINE_POSE_MINUTES says for
// how long (8).
#include <malloc.h>

#include <cstdlib>

#include <gtest/gtest.h>

#include "engine/base/timer.h"
#include "engine/pipeline/own_pose_sequence.h"
#include "tests/support/simulated_sequence.h"

namespace plumbline {
namespace {

constexpr double kHz = 10;

double AllocatedMb() {
  return static_cast<double>(mallinfo2().uordblks + mallinfo2().hblkhd) / 1e6;
}

TEST(OwnPoseHours, MemoryAndTimeAnImageStayWhatTheyAre) {
  const char* told = std::getenv("PLUMBLINE_POSE_MINUTES");
  const double minutes = told != nullptr ? std::atof(told) : 8;
  const auto film = SimulatedSequence(Simulate({.seconds = 60 * minutes,
                                                .room_points = 420,
                                                .follow_all = true,
                                                .image_hz = kHz,
                                                .pixel_noise_px = 0,
                                                .imu_noise = 3}));
  OwnPoseOptions options;
  options.loops = LoopUse::kCausal;
  const double before_mb = AllocatedMb();
  const auto sequence =
      WithOwnPoses(film, OwnPoseEstimator::Create(film, film->num_frames(), options).value());
  const auto store = OwnPoseStoreOf(*sequence);
  OwnPoseSource source(sequence);
  OwnPosesTaken taken;
  // Eighths of the walk; a mapper takes all packets, and whoever records it what is new.
  const int part = film->num_frames() / 8;
  std::vector<double> mb, ms;
  std::size_t corrected = 0, images = 0, corrections = 0;
  Stopwatch watch;
  while (true) {
    const auto packet = source.Next({});
    ASSERT_TRUE(packet.ok()) << packet.error().message;
    if (!*packet) break;
    if (const auto* pose = std::get_if<PoseEstimate>(&**packet))
      corrected += static_cast<std::size_t>(pose->id.value < store->known() - 40);
    const auto* frame = std::get_if<FramePacket>(&**packet);
    if (frame == nullptr || (frame->frame + 1) % part != 0) continue;
    const auto growth = taken.Rest(*store);
    images += growth->poses.frames.size();
    corrections += growth->poses.corrections.size();
    mb.push_back(AllocatedMb() - before_mb);
    ms.push_back(watch.Milliseconds() / part);
    watch = Stopwatch();
    const LoopReport& loops = growth->poses.loops;
    std::printf(
        "%5.1f min: %6.1f MB, of which key frames %5.1f; %5.1f ms an image; %d key frames, "
        "%d loops closed\n",
        frame->frame / kHz / 60, mb.back(), loops.bytes / 1e6, ms.back(), loops.key_frames,
        static_cast<int>(loops.closures.size()));
  }
  const auto rest = taken.Rest(*store);
  EXPECT_EQ(images + rest->poses.frames.size(), static_cast<std::size_t>(film->num_frames()));
  EXPECT_GT(corrections, 10u);
  EXPECT_GT(corrected, images) << "what was told is told again as loops close";
  ASSERT_GE(mb.size(), 8u);
  // The whole of an hour is in docs/processes.md; here that nothing runs away.
  EXPECT_LT(mb[7] - mb[3], 16 * minutes / 2) << "at most 16 MB a minute, most of it key frames";
}

}  // namespace
}  // namespace plumbline
