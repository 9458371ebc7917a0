// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/live_source.h"

#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "engine/sources/selected_frames.h"

namespace plumbline {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

constexpr std::int64_t kMs = 1000000;

/// A clock that stands still until somebody waits or works.
class FakeClock : public LiveClock {
 public:
  std::int64_t NowNs() const override { return now_ns_; }
  void WaitUntil(std::int64_t time_ns, const std::stop_token& stop) override {
    if (!stop.stop_requested() && time_ns > now_ns_) now_ns_ = time_ns + late_ns_;
  }
  void Work(std::int64_t ms) { now_ns_ += ms * kMs; }
  void WakeLate(std::int64_t ms) { late_ns_ = ms * kMs; }

 private:
  std::int64_t now_ns_ = 123 * kMs, late_ns_ = 0;
};

/// Frames of given stamps; each has an IMU sample and its pose before it.
class Recording : public FrameSource {
 public:
  explicit Recording(std::vector<std::int64_t> stamps_ms) {
    for (std::size_t i = 0; i < stamps_ms.size(); ++i) {
      const std::int64_t stamp_ns = stamps_ms[i] * kMs;
      ImuSample sample;
      sample.stamp_ns = stamp_ns;
      PoseEstimate pose;
      pose.id = PoseId{static_cast<int>(i)};
      pose.stamp_ns = stamp_ns;
      packets_.insert(packets_.end(),
                      {sample, pose, FramePacket{static_cast<int>(i), 0, stamp_ns, nullptr}});
    }
  }
  void Add(Packet packet) { packets_.push_back(std::move(packet)); }
  void EndWith(Error error) { error_ = std::move(error); }

  const Calibration& calibration() const override { return calibration_; }
  Result<std::optional<Packet>> Next(const std::stop_token&) override {
    if (next_ < packets_.size()) return std::optional(packets_[next_++]);
    if (error_) return *error_;
    return std::optional<Packet>();
  }

 private:
  Calibration calibration_;
  std::vector<Packet> packets_;
  std::optional<Error> error_;
  std::size_t next_ = 0;
};

/// What a consumer was given that needs `work_ms` for each frame.
struct Seen {
  std::vector<int> frames, poses;
  std::vector<std::int64_t> at_ms;  ///< After the first.
  int samples = 0;
  std::string error;
};

Seen Play(LiveSource& live, FakeClock& clock, std::int64_t work_ms) {
  Seen seen;
  const std::int64_t start_ns = clock.NowNs();
  while (true) {
    const auto packet = live.Next({});
    if (!packet.ok()) seen.error = packet.error().message;
    if (!packet.ok() || !packet.value()) return seen;
    if (std::holds_alternative<ImuSample>(**packet)) ++seen.samples;
    if (const auto* pose = std::get_if<PoseEstimate>(&**packet))
      seen.poses.push_back(pose->id.value);
    const auto* frame = std::get_if<FramePacket>(&**packet);
    if (frame == nullptr) continue;
    EXPECT_EQ(seen.poses.back(), frame->frame) << "its pose comes before it";
    seen.frames.push_back(frame->frame);
    seen.at_ms.push_back((clock.NowNs() - start_ns) / kMs);
    clock.Work(work_ms);
    live.Done(frame->frame);
  }
}

struct Player {
  explicit Player(std::vector<std::int64_t> stamps_ms, double speed = 1)
      : recording(std::move(stamps_ms)), live(recording, speed, clock) {}
  Seen PlayWith(std::int64_t work_ms) { return Play(live, *clock, work_ms); }

  std::shared_ptr<FakeClock> clock = std::make_shared<FakeClock>();
  Recording recording;
  LiveSource live;
};

const std::vector<std::int64_t> kTenHz = {1000, 1100, 1200, 1300, 1400, 1500, 1600};

TEST(LiveSource, GivesAFastConsumerEveryFrameWhenItComes) {
  Player player(kTenHz);
  const Seen seen = player.PlayWith(30);
  EXPECT_THAT(seen.frames, ElementsAre(0, 1, 2, 3, 4, 5, 6));
  EXPECT_THAT(seen.at_ms, ElementsAre(0, 100, 200, 300, 400, 500, 600));
  const LiveReport report = player.live.report();
  EXPECT_EQ(report.taken, 7);
  EXPECT_EQ(report.done, 7);
  EXPECT_EQ(report.passed_over, 0);
  EXPECT_THAT(report.recorded_s, DoubleNear(0.6, 1e-9));
  EXPECT_THAT(report.taken_age_ms, DoubleNear(0, 1e-9));
  EXPECT_THAT(report.done_age_ms, DoubleNear(30, 1e-9));
}

TEST(LiveSource, GivesASlowConsumerTheNewestAndCountsTheOthers) {
  Player player(kTenHz);
  const Seen seen = player.PlayWith(250);
  EXPECT_THAT(seen.frames, ElementsAre(0, 2, 5, 6)) << "ready at 0, 250, 500 and 750 ms";
  EXPECT_THAT(seen.at_ms, ElementsAre(0, 250, 500, 750));
  const LiveReport report = player.live.report();
  EXPECT_EQ(report.taken, 4);
  EXPECT_EQ(report.passed_over, 3);
  EXPECT_EQ(report.came(), 7);
  EXPECT_THAT(report.taken_age_ms, DoubleNear((0 + 50 + 0 + 150) / 4.0, 1e-9));
  EXPECT_THAT(report.done_age_ms, DoubleNear(250 + 50, 1e-9));
}

TEST(LiveSource, LosesNothingThatIsNoFrame) {
  Player player(kTenHz);
  ImuSample last;
  last.stamp_ns = 1650 * kMs;
  player.recording.Add(last);
  const Seen seen = player.PlayWith(250);
  EXPECT_THAT(seen.poses, ElementsAre(0, 1, 2, 3, 4, 5, 6));
  EXPECT_EQ(seen.samples, 8);
}

TEST(LiveSource, AlwaysReachesTheLastFrame) {
  for (const std::int64_t work_ms : {1, 99, 100, 101, 333, 5000}) {
    Player player(kTenHz);
    const Seen seen = player.PlayWith(work_ms);
    EXPECT_EQ(seen.frames.back(), 6) << work_ms << " ms a frame";
    EXPECT_EQ(player.live.report().came(), 7) << work_ms << " ms a frame";
  }
}

TEST(LiveSource, PassesOverWhatCameWhileItOverslept) {
  Player player(kTenHz);
  player.clock->WakeLate(120);
  EXPECT_THAT(player.PlayWith(1).frames, ElementsAre(0, 2, 4, 6));
}

TEST(LiveSource, PlaysFasterAndSlower) {
  Player half(kTenHz, 0.5);
  EXPECT_THAT(half.PlayWith(250).frames, ElementsAre(0, 1, 2, 3, 5, 6));
  EXPECT_THAT(half.live.report().recorded_s, DoubleNear(0.6, 1e-9)) << "of the recording";
  Player twice(kTenHz, 2);
  EXPECT_THAT(twice.PlayWith(60).at_ms, ElementsAre(0, 60, 120, 180, 240, 300));
}

TEST(LiveSource, TakesStampsThatDoNotRiseWithTheFrameBefore) {
  Player doubled({0, 100, 100, 200});
  EXPECT_THAT(doubled.PlayWith(1).frames, ElementsAre(0, 2, 3)) << "of two at once the newer";
  EXPECT_EQ(doubled.live.report().passed_over, 1);
  Player backwards({500, 600, 50, 700});
  EXPECT_THAT(backwards.PlayWith(1).frames, ElementsAre(0, 2, 3));
  Player same({7, 7, 7});
  const Seen seen = same.PlayWith(1);
  EXPECT_THAT(seen.frames, ElementsAre(2));
  EXPECT_THAT(seen.at_ms, ElementsAre(0));
}

TEST(LiveSource, WaitsThroughAHoleInTheRecording) {
  Player player({0, 100, 60000, 60100});
  const Seen seen = player.PlayWith(10);
  EXPECT_THAT(seen.frames, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(seen.at_ms, ElementsAre(0, 100, 60000, 60100));
}

TEST(LiveSource, PlaysOneFrameAndNone) {
  Player one({1234567});
  const Seen seen = one.PlayWith(10);
  EXPECT_THAT(seen.frames, ElementsAre(0));
  EXPECT_EQ(one.live.report().recorded_s, 0);
  EXPECT_FALSE(one.live.Next({}).value()) << "the end stays the end";
  Player none({});
  EXPECT_TRUE(none.PlayWith(10).frames.empty());
  EXPECT_EQ(none.live.report().came(), 0);
}

TEST(LiveSource, GivesWhatCameBeforeAnErrorAndThenTheError) {
  Player player({0, 100});
  player.recording.EndWith({ErrorCode::kCorrupt, "the disk is gone"});
  const Seen seen = player.PlayWith(10);
  EXPECT_THAT(seen.frames, ElementsAre(0, 1));
  EXPECT_EQ(seen.error, "the disk is gone");
}

TEST(LiveSource, StopsWaitingWhenAskedTo) {
  Recording recording({0, 3600 * 1000});
  LiveSource live(recording, 1);
  std::stop_source stop;
  std::vector<ErrorCode> ended;
  std::thread consumer([&] {
    while (true) {
      const auto packet = live.Next(stop.get_token());
      if (packet.ok()) continue;
      ended.push_back(packet.error().code);
      return;
    }
  });
  stop.request_stop();
  consumer.join();  // within an hour
  EXPECT_THAT(ended, ElementsAre(ErrorCode::kCancelled));
}

TEST(LiveSource, PlaysByTheClockOfTheMachine) {
  Recording recording({0, 10, 20});
  LiveSource live(recording, 1);
  const auto start = std::chrono::steady_clock::now();
  while (live.Next({}).value()) continue;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  EXPECT_GE(took.count(), 0.02);
  EXPECT_EQ(live.report().came(), 3);
}

TEST(SelectedFrames, LeavesOutTheOtherFramesAndEndsAfterTheLast) {
  Recording recording(kTenHz);
  SelectedFrames selected(recording, 1, 5, 2);
  std::vector<int> frames, poses;
  while (true) {
    const auto packet = selected.Next({});
    if (!packet.value()) break;
    if (const auto* frame = std::get_if<FramePacket>(&**packet)) frames.push_back(frame->frame);
    if (const auto* pose = std::get_if<PoseEstimate>(&**packet)) poses.push_back(pose->id.value);
  }
  EXPECT_THAT(frames, ElementsAre(1, 3, 5));
  EXPECT_THAT(poses, ElementsAre(0, 1, 2, 3, 4, 5));
}

/// So many frames have come.
class Come : public GrowingRecording {
 public:
  bool HasFrame(int frame) const override { return frame < frames; }
  bool WaitForFrame(int frame, const std::stop_token&) const override { return frame < frames; }
  std::vector<ImuSample> WaitForImu(std::size_t, std::int64_t,
                                    const std::stop_token&) const override {
    return {};
  }
  std::int64_t CameNs(int) const override { return 0; }
  bool ended() const override { return false; }
  int frames = 0;
};

TEST(LiveSource, OfARecordingThatGrowsGivesTheNewestAndWaitsForNoOther) {
  Recording recording(kTenHz);
  Come come;
  LiveSource live(recording, come, 1);
  const auto next_frame = [&](int& samples) {
    while (true) {
      const auto packet = live.Next({});
      if (std::holds_alternative<ImuSample>(**packet)) ++samples;
      if (const auto* frame = std::get_if<FramePacket>(&**packet)) return frame->frame;
    }
  };
  int samples = 0;
  come.frames = 3;
  EXPECT_EQ(next_frame(samples), 2);
  EXPECT_EQ(samples, 3) << "what is no frame is never lost";
  EXPECT_EQ(live.report().passed_over, 2);
  come.frames = 4;
  EXPECT_EQ(next_frame(samples), 3) << "at once, though the next has not come";
  come.frames = 7;
  EXPECT_EQ(next_frame(samples), 6);
  EXPECT_EQ(samples, 7);
  EXPECT_EQ(live.report().came(), 7);
  EXPECT_THAT(live.report().recorded_s, DoubleNear(0.6, 1e-9));
}

TEST(LiveSource, OfARecordingThatGrowsWaitsForTheStep) {
  Recording recording(kTenHz);
  SelectedFrames every_third(recording, 0, 1000, 3);
  Come come;
  LiveSource live(every_third, come, 3);
  const auto next_frame = [&] {
    while (true) {
      const auto packet = live.Next({});
      if (const auto* frame = std::get_if<FramePacket>(&**packet)) return frame->frame;
    }
  };
  come.frames = 6;
  EXPECT_EQ(next_frame(), 3) << "6 has not come";
  come.frames = 7;
  EXPECT_EQ(next_frame(), 6);
}

}  // namespace
}  // namespace plumbline
