// SPDX-License-Identifier: Apache-2.0
// A run file is looked at while somebody writes it.
#include <chrono>
#include <filesystem>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/recording/run_file.h"
#include "engine/runtime/mapping_process.h"
#include "engine/runtime/run_source.h"
#include "engine/snapshot/map_snapshot.h"
#include "tests/engine/recording/random_run.h"
#include "tests/engine/runtime/box_run.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

bool Becomes(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

class GrowingRun : public testing::Test {
 protected:
  void SetUp() override {
    WriteBoxModels(folder_.path() / "models");
    WriteBoxSequence(folder_.path() / "sequence", 40);
    auto writer = RunWriter::Create(
        run_, HeaderOfBoxRun(folder_.path() / "sequence", folder_.path() / "models"));
    ASSERT_TRUE(writer.ok()) << writer.error().message;
    writer_ = std::move(writer).value();
  }

  /// Until they are in the file.
  void WriteFrames(int frames) {
    for (int i = 0; i < frames; ++i)
      ASSERT_TRUE(writer_->Write(FrameOfBoxRun(next_++), RandomImage(3)).ok());
    ASSERT_TRUE(Becomes([&] { return writer_->num_written() == next_; }));
  }

  std::unique_ptr<MappingProcess> Look() const {
    return std::make_unique<MappingProcess>(
        [run = run_](const WorkContext& work) {
          return OpenRunSource({run, {}, {}}, work);
        },
        std::nullopt, std::function<void()>());
  }

  static bool Shows(const MappingProcess& process, int frame) {
    return Becomes([&] {
      const auto shown = process.Snapshot();
      return shown != nullptr && shown->report.frame == frame;
    });
  }

  TemporaryFolder folder_;
  const std::filesystem::path run_ = folder_.path() / "run.plb";
  std::unique_ptr<RunWriter> writer_;
  int next_ = 0;
};

TEST_F(GrowingRun, IsFollowedToItsEnd) {
  WriteFrames(3);
  const auto process = Look();
  ASSERT_TRUE(Shows(*process, 2)) << "the newest first: " << process->Playback()->message;
  EXPECT_TRUE(process->Playback()->growing);
  EXPECT_TRUE(process->Playback()->recorded);
  EXPECT_EQ(process->Playback()->state, PlaybackState::kPlaying);
  WriteFrames(4);
  ASSERT_TRUE(Shows(*process, 6));
  EXPECT_FALSE(process->Snapshot()->depth.empty()) << "pictures are made as of any past frame";
  EXPECT_TRUE(Becomes([&] {
    const auto& frames = process->Playback()->history->frames;
    return frames.size() == 7 && frames.back() != nullptr;
  }));
  ASSERT_TRUE(writer_->Close().ok());
  EXPECT_TRUE(Becomes([&] { return process->Playback()->state != PlaybackState::kPlaying; }));
  writer_.reset();
  ASSERT_TRUE(Becomes([&] { return process->Playback()->state == PlaybackState::kFinished; }));
  EXPECT_FALSE(process->Playback()->growing);
  EXPECT_EQ(process->Playback()->newest_mapped_frame, 6);
}

TEST_F(GrowingRun, LookingBackTheNewestStaysWhereItIsUntilItIsAskedFor) {
  WriteFrames(5);
  const auto process = Look();
  ASSERT_TRUE(Shows(*process, 4));
  process->Post(StepCommand{-2});
  ASSERT_TRUE(Shows(*process, 2));
  WriteFrames(3);
  ASSERT_TRUE(Becomes([&] { return process->Playback()->newest_mapped_frame == 7; }));
  EXPECT_EQ(process->Playback()->frame, 2);
  EXPECT_FALSE(process->Playback()->follow);
  process->Post(FollowNewestCommand{});
  ASSERT_TRUE(Shows(*process, 7));
  process->Post(PauseCommand{});
  ASSERT_TRUE(Becomes([&] { return process->Playback()->state == PlaybackState::kPaused; }));
  WriteFrames(1);
  ASSERT_TRUE(Becomes([&] { return process->Playback()->newest_mapped_frame == 8; }));
  EXPECT_EQ(process->Playback()->frame, 7);
  process->Post(StepCommand{5});  // beyond the newest: on with it
  ASSERT_TRUE(Shows(*process, 8));
  WriteFrames(1);
  EXPECT_TRUE(Shows(*process, 9));
}

TEST_F(GrowingRun, PlayingThatReachesTheNewestFrameFollowsIt) {
  WriteFrames(4);
  const auto process = Look();
  ASSERT_TRUE(Shows(*process, 3));
  process->Post(SetSpeedCommand{0});
  process->Post(SeekCommand{0});
  ASSERT_TRUE(Shows(*process, 0));
  process->Post(PlayCommand{});
  ASSERT_TRUE(Shows(*process, 3));
  WriteFrames(2);
  ASSERT_TRUE(Shows(*process, 5));
  EXPECT_TRUE(process->Playback()->follow);
}

TEST_F(GrowingRun, OneThatHasNoFrameYetIsWaitedFor) {
  const auto process = Look();
  ASSERT_TRUE(Becomes(
      [&] { return process->Playback()->message.find("first frame") != std::string::npos; }));
  WriteFrames(1);
  EXPECT_TRUE(Shows(*process, 0));
}

TEST_F(GrowingRun, OfAWriterThatDiedItWaitsForTheNext) {
  WriteFrames(2);
  const auto process = Look();
  ASSERT_TRUE(Shows(*process, 1));
  // As if killed: the lock is gone, and the file does not say that it ended.
  ASSERT_TRUE(writer_->Close().ok());
  writer_.reset();
  auto again = RunWriter::Reopen(run_);
  ASSERT_TRUE(again.ok()) << again.error().message;
  writer_ = std::move(again->writer);
  WriteFrames(2);
  EXPECT_TRUE(Shows(*process, 3));
  EXPECT_TRUE(process->Playback()->growing);
}

}  // namespace
}  // namespace plumbline
