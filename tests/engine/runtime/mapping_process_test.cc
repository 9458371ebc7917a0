// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/mapping_process.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include "engine/snapshot/map_snapshot.h"
#include "tests/support/fake_source.h"

namespace plumbline {
namespace {

FakeSourceOptions Small() {
  FakeSourceOptions options;
  options.num_frames = 30;
  options.width = 64;
  options.height = 36;
  options.particles = 5;
  return options;
}

MappingProcess::OpenSource Opener(const FakeSourceOptions& options) {
  return [options](const WorkContext&) -> Result<std::unique_ptr<SnapshotSource>> {
    return MakeFakeSource(options);
  };
}

bool WaitFor(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

bool Shows(const MappingProcess& process, int frame) {
  return WaitFor([&] {
    const auto snapshot = process.Snapshot();
    return snapshot != nullptr && snapshot->report.frame == frame &&
           process.Playback()->frame == frame;
  });
}

TEST(MappingProcess, ShowsTheFirstFrameAndRests) {
  MappingProcess process(Opener(Small()), std::nullopt, {});
  ASSERT_TRUE(Shows(process, 0));
  EXPECT_EQ(process.Playback()->state, PlaybackState::kPaused);
  EXPECT_TRUE(WaitFor([&] { return process.Playback()->newest_mapped_frame == 0; }));
  EXPECT_EQ(process.Sequence()->num_frames, 30);
}

TEST(MappingProcess, StepsForwardByMappingAndBackByRemembering) {
  MappingProcess process(Opener(Small()), std::nullopt, {});
  ASSERT_TRUE(Shows(process, 0));
  process.Post(StepCommand{3});
  ASSERT_TRUE(Shows(process, 3));
  process.Post(StepCommand{-2});
  ASSERT_TRUE(Shows(process, 1));
  EXPECT_EQ(process.Playback()->newest_mapped_frame, 3);
}

TEST(MappingProcess, PlaysToTheEndAndFinishes) {
  MappingProcess process(Opener(Small()), std::nullopt, {});
  process.Post(SetSpeedCommand{0});
  process.Post(PlayCommand{});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kFinished; }));
  EXPECT_EQ(process.Playback()->frame, 29);
  process.Post(SetSpeedCommand{1});
  process.Post(PlayCommand{});  // from the beginning again
  ASSERT_TRUE(WaitFor([&] {
    return process.Playback()->state == PlaybackState::kPlaying || process.Playback()->frame < 29;
  }));
}

TEST(MappingProcess, PlaysAtTheRateOfTheSequence) {
  FakeSourceOptions options = Small();
  options.recorded = true;
  MappingProcess process(Opener(options), std::nullopt, {});
  ASSERT_TRUE(Shows(process, 0));
  const auto start = std::chrono::steady_clock::now();
  process.Post(PlayCommand{});
  ASSERT_TRUE(Shows(process, 29));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_GT(seconds, 0.9);  // 29 frames at 30 Hz are 0.97 s; a busy machine may take longer
}

TEST(MappingProcess, TellsARateThatItReallyPlaysAt) {
  FakeSourceOptions options = Small();
  options.recorded = true;
  MappingProcess process(Opener(options), std::nullopt, {});
  ASSERT_TRUE(Shows(process, 0));
  process.Post(SeekCommand{2});  // two frames at once say nothing of a rate
  process.Post(PlayCommand{});
  double most = 0;
  ASSERT_TRUE(WaitFor([&] {
    most = std::max(most, process.Playback()->frames_per_second);
    return process.Playback()->state == PlaybackState::kFinished;
  }));
  EXPECT_GT(most, 1);
  EXPECT_LT(most, 45) << "30 Hz";
  EXPECT_EQ(process.Playback()->frames_per_second, 0) << "at rest";
}

TEST(MappingProcess, WorksOutTheTimesOfTheRunWhileTheyAreWatched) {
  FakeSourceOptions options = Small();
  options.recorded = true;
  MappingProcess process(Opener(options), std::nullopt, {});
  ASSERT_TRUE(Shows(process, 0));
  EXPECT_EQ(process.Timings(), nullptr);
  WatchCommand watch;
  watch.timings = true;
  process.Post(watch);
  ASSERT_TRUE(WaitFor([&] { return process.Timings() != nullptr; }));
  EXPECT_EQ(process.Timings()->frames, 30) << "all, though one was shown";
}

TEST(MappingProcess, SeeksAheadByMappingTowardsTheFrame) {
  FakeSourceOptions options = Small();
  options.milliseconds_per_frame = 20;
  MappingProcess process(Opener(options), std::nullopt, {});
  ASSERT_TRUE(Shows(process, 0));
  process.Post(SeekCommand{10});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->seek_target == 10; }));
  ASSERT_TRUE(Shows(process, 10));
  EXPECT_FALSE(process.Playback()->seek_target.has_value());
}

TEST(MappingProcess, StepsAlongTheFramesThatARunHas) {
  FakeSourceOptions options = Small();
  options.stride = 4;
  MappingProcess process(Opener(options), std::nullopt, {});
  ASSERT_TRUE(Shows(process, 0));
  process.Post(StepCommand{2});
  ASSERT_TRUE(Shows(process, 8));
  process.Post(SeekCommand{19});
  ASSERT_TRUE(Shows(process, 16));
  process.Post(SeekCommand{1000});
  ASSERT_TRUE(Shows(process, 28));
  EXPECT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kFinished; }));
}

TEST(MappingProcess, FollowsALiveSourceFromTheStartToItsLastFrame) {
  FakeSourceOptions options = Small();
  options.live_passes_over = 3;
  MappingProcess process(Opener(options), std::nullopt, {});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kFinished; }));
  EXPECT_EQ(process.Playback()->frame, 29) << "0, 4, 8 .. 28, and the last";
  ASSERT_TRUE(process.Playback()->live);
  EXPECT_EQ(process.Playback()->live->done, 9);
  EXPECT_EQ(process.Playback()->live->passed_over, 21);
  process.Post(SeekCommand{11});
  EXPECT_TRUE(Shows(process, 8)) << "the last before it that was mapped";
  process.Post(StepCommand{1});
  EXPECT_TRUE(Shows(process, 12));
}

TEST(MappingProcess, MapsTheNewestFrameOfALiveSourceWhereItIsAskedForALaterOne) {
  FakeSourceOptions options = Small();
  options.live_passes_over = 3;
  options.milliseconds_per_frame = 30;
  MappingProcess process(Opener(options), std::nullopt, {});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->frame >= 4; }));
  process.Post(PauseCommand{});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kPaused; }));
  const int newest = process.Playback()->newest_mapped_frame;
  process.Post(SeekCommand{29});
  ASSERT_TRUE(Shows(process, std::min(newest + 4, 29)));
  EXPECT_EQ(process.Playback()->seek_target, std::nullopt);
  EXPECT_EQ(process.Playback()->newest_mapped_frame, std::min(newest + 4, 29));
  process.Post(PlayCommand{});
  EXPECT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kFinished; }));
}

TEST(MappingProcess, PauseInterruptsASeek) {
  FakeSourceOptions options = Small();
  options.milliseconds_per_frame = 20;
  MappingProcess process(Opener(options), std::nullopt, {});
  ASSERT_TRUE(Shows(process, 0));
  process.Post(SeekCommand{29});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->frame >= 2; }));
  process.Post(PauseCommand{});
  ASSERT_TRUE(WaitFor([&] {
    return process.Playback()->state == PlaybackState::kPaused && !process.Playback()->seek_target;
  }));
  EXPECT_LT(process.Playback()->frame, 29);
}

TEST(MappingProcess, MapsOnWhileThePastIsShownAndFollowsAgain) {
  FakeSourceOptions options = Small();
  options.num_frames = 400;
  options.milliseconds_per_frame = 2;
  MappingProcess process(Opener(options), std::nullopt, {});
  ASSERT_TRUE(Shows(process, 0));
  process.Post(FollowNewestCommand{});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->frame >= 10; }));
  EXPECT_TRUE(process.Playback()->follow);
  EXPECT_EQ(process.Playback()->state, PlaybackState::kPlaying);
  process.Post(SeekCommand{3});
  ASSERT_TRUE(Shows(process, 3));
  const int newest = process.Playback()->newest_mapped_frame;
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->newest_mapped_frame > newest + 10; }));
  EXPECT_EQ(process.Playback()->frame, 3) << "the past stays on the screen";
  EXPECT_TRUE(process.Playback()->mapping);
  EXPECT_FALSE(process.Playback()->follow);
  process.Post(StepCommand{1});
  ASSERT_TRUE(Shows(process, 4));
  process.Post(FollowNewestCommand{});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->frame > newest; }));
  process.Post(FollowNewestCommand{false});
  ASSERT_TRUE(WaitFor([&] { return !process.Playback()->mapping; }));
  EXPECT_EQ(process.Playback()->state, PlaybackState::kPaused);
  EXPECT_EQ(process.Playback()->frame, process.Playback()->newest_mapped_frame);
  process.Post(FollowNewestCommand{});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kFinished; }));
  EXPECT_EQ(process.Playback()->frame, 399);
  EXPECT_FALSE(process.Playback()->mapping);
}

TEST(MappingProcess, PlaysThePastWhileItMapsOn) {
  FakeSourceOptions options = Small();
  options.num_frames = 400;
  options.milliseconds_per_frame = 2;
  MappingProcess process(Opener(options), std::nullopt, {});
  process.Post(FollowNewestCommand{});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->frame >= 30; }));
  process.Post(SeekCommand{0});
  ASSERT_TRUE(Shows(process, 0));
  process.Post(TogglePlayCommand{});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->frame == 2; }));
  EXPECT_EQ(process.Playback()->state, PlaybackState::kPlaying);
  process.Post(TogglePlayCommand{});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kPaused; }));
  EXPECT_TRUE(process.Playback()->mapping) << "Space stops the playing only";
  process.Post(PauseCommand{});
  ASSERT_TRUE(WaitFor([&] { return !process.Playback()->mapping; }));
}

TEST(MappingProcess, KeepsTheMappedFramesAfterAFailure) {
  FakeSourceOptions options = Small();
  options.fail_at_frame = 5;
  MappingProcess process(Opener(options), std::nullopt, {});
  process.Post(SeekCommand{20});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kFailed; }));
  EXPECT_NE(process.Playback()->message.find("cannot be read"), std::string::npos);
  process.Post(SeekCommand{2});
  ASSERT_TRUE(Shows(process, 2));
  process.Post(SeekCommand{20});
  ASSERT_TRUE(Shows(process, 4));
}

TEST(MappingProcess, TurnsAnExceptionIntoAFailure) {
  FakeSourceOptions options = Small();
  options.throw_at_frame = 3;
  MappingProcess process(Opener(options), 20, {});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kFailed; }));
  EXPECT_NE(process.Playback()->message.find("made-up exception"), std::string::npos);
}

TEST(MappingProcess, ReportsASourceThatDoesNotOpen) {
  MappingProcess process(
      [](const WorkContext&) -> Result<std::unique_ptr<SnapshotSource>> {
        return Error{ErrorCode::kNotFound, "there is no such sequence"};
      },
      std::nullopt, {});
  ASSERT_TRUE(WaitFor([&] { return process.Playback()->state == PlaybackState::kFailed; }));
  EXPECT_EQ(process.Playback()->message, "there is no such sequence");
  EXPECT_EQ(process.Sequence(), nullptr);
}

TEST(MappingProcess, StopsWithinFiftyMilliseconds) {
  FakeSourceOptions options = Small();
  options.milliseconds_per_frame = 5000;
  std::chrono::steady_clock::time_point start;
  {
    MappingProcess process(Opener(options), std::nullopt, {});
    ASSERT_TRUE(WaitFor([&] { return process.Sequence() != nullptr; }));
    start = std::chrono::steady_clock::now();
  }
  const auto elapsed = std::chrono::steady_clock::now() - start;
  EXPECT_LT(elapsed,
            std::chrono::milliseconds(250));  // 50 by design; a busy machine gets five times that
}

TEST(MappingProcess, PublishesEveryEventWhateverFramesAreShown) {
  MappingProcess process(Opener(Small()), std::nullopt, {});
  process.Post(SeekCommand{29});
  ASSERT_TRUE(Shows(process, 29));
  int spawned = 0;
  for (const FrameEvent& event : *process.Playback()->events) {
    spawned += event.event.kind == EventKind::kSpawned;
  }
  EXPECT_EQ(spawned, 5);
}

TEST(MappingProcess, WorksOutWhatIsWatchedAndNothingElse) {
  FakeSourceOptions options = Small();
  options.recorded = true;
  MappingProcess process(Opener(options), 29, {});
  ASSERT_TRUE(Shows(process, 29));
  ASSERT_NE(process.Analysis(), nullptr);
  EXPECT_EQ(process.Analysis()->frame, process.Snapshot());
  EXPECT_FALSE(process.Analysis()->relations.has_value());
  EXPECT_EQ(process.History(), nullptr);
  process.Post(WatchCommand{{1}, true, true});
  ASSERT_TRUE(WaitFor([&] { return process.Analysis()->relations.has_value(); }));
  ASSERT_TRUE(WaitFor([&] { return process.History() != nullptr; }));
  EXPECT_FALSE(process.Analysis()->relations->empty());
  EXPECT_EQ(process.Analysis()->object, ObjectId{1});
  EXPECT_EQ(process.Analysis()->by_rank.size(), 5u);
  EXPECT_EQ(process.History()->object, ObjectId{1});
  EXPECT_EQ(process.History()->labels.frames.size(), 30u);
  process.Post(StepCommand{-1});
  ASSERT_TRUE(Shows(process, 28));
  EXPECT_EQ(process.Analysis()->frame, process.Snapshot()) << "it is there with its frame";
  EXPECT_TRUE(process.Analysis()->relations.has_value());
  process.Post(WatchCommand{});
  EXPECT_TRUE(WaitFor([&] { return process.History() == nullptr; }));
}

}  // namespace
}  // namespace plumbline
