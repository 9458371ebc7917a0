// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/recording_writer.h"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/growing_recording.h"
#include "engine/dataset/growing_sequence.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

class RecordingWriterTest : public testing::Test {
 protected:
  RecordingWriterTest() { WriteTinySequence(temporary_.path() / "tiny", {.frames = 3}); }
  nlohmann::json Camera() const { return ReadJson(temporary_.path() / "tiny/camera.json").value(); }
  std::string Image(int number) const {
    return ReadFile(temporary_.path() / "tiny/color" / (FrameName(number) + ".jpg")).value();
  }
  TemporaryFolder temporary_;
  std::filesystem::path folder_ = temporary_.path() / "recording";
};

TEST_F(RecordingWriterTest, WhatItWritesIsFollowedAndThenOpened) {
  auto writer =
      RecordingWriter::Create(folder_, Camera(), nlohmann::json{{"rate_hz", 100}}).value();
  EXPECT_TRUE(IsBeingRecorded(folder_));
  const ImuSample early{-5, {1.0 / 3, 0, 0}, {0, 0, 9.81}},
      late{2'000'000'001, {0, 1, 0}, {1, 2, 3}};
  ASSERT_TRUE(writer->AddReadings(std::vector{early, late}).ok());
  ASSERT_TRUE(writer->AddImage(1'000'000'007, Image(0), ".jpg").ok());
  ASSERT_TRUE(writer->AddImage(1'100'000'000, Image(1), ".jpg").ok());
  const auto following = FollowRecording(folder_, {});
  ASSERT_TRUE(following.ok()) << following.error().message;
  EXPECT_EQ((*following)->num_frames(), 2);
  EXPECT_EQ((*following)->calibration().imu->rate_hz, 100);
  ASSERT_TRUE(writer->AddImage(1'200'000'000, Image(2), ".jpg").ok());
  EXPECT_TRUE(GrowingRecordingOf(**following)->WaitForFrame(2, {}));
  EXPECT_EQ(writer->num_images(), 3);
  writer.reset();
  EXPECT_FALSE(IsBeingRecorded(folder_));
  const auto sequence = OpenSequence(folder_).value();
  ASSERT_EQ(sequence->num_frames(), 3);
  EXPECT_EQ(sequence->stamp_ns(0), 1'000'000'007);
  EXPECT_TRUE(sequence->warnings().empty());
  EXPECT_TRUE(sequence->ReadRawImage(2).ok());
  const ImuRecording imu = sequence->ReadImu().value();
  ASSERT_EQ(imu.samples.size(), 2u);
  EXPECT_EQ(imu.samples[0].stamp_ns, -5);
  EXPECT_NEAR(imu.samples[0].angular_velocity_rad_s.x(), 1.0 / 3, 1e-9);
  EXPECT_EQ(imu.samples[1].stamp_ns, 2'000'000'001);
}

TEST_F(RecordingWriterTest, IsJoinedByTwoThatMayDie) {
  auto begun = RecordingWriter::Create(folder_, Camera(), {}).value();
  const std::unique_ptr<FileLock> kept = begun->TakeLock();
  begun.reset();
  EXPECT_TRUE(IsBeingRecorded(folder_));
  auto camera = RecordingWriter::Join(folder_).value(),
       imu = RecordingWriter::Join(folder_).value();
  EXPECT_FALSE(imu->joined_readings());
  ASSERT_TRUE(camera->AddImage(1'000'000'000, Image(0), ".jpg").ok());
  ASSERT_TRUE(imu->AddReadings(std::vector{ImuSample{0, {0, 0, 0}, {0, 0, 9.8}}}).ok());
  // The camera dies in the middle of a row.
  camera.reset();
  std::ofstream(folder_ / "color.csv", std::ios::app) << "1.0500";
  camera = RecordingWriter::Join(folder_).value();
  EXPECT_TRUE(camera->joined_readings());
  ASSERT_TRUE(camera->AddImage(1'100'000'000, Image(1), ".jpg").ok());
  ASSERT_TRUE(imu->AddReadings(std::vector{ImuSample{5'000'000, {0, 0, 0}, {0, 0, 9.8}}}).ok());
  const auto sequence = OpenSequence(folder_).value();
  ASSERT_EQ(sequence->num_frames(), 2);
  EXPECT_EQ(sequence->stamp_ns(1), 1'100'000'000);
  EXPECT_TRUE(sequence->ReadRawImage(0).ok());
  EXPECT_TRUE(sequence->ReadRawImage(1).ok());
  EXPECT_EQ(sequence->ReadImu().value().samples.size(), 2u);
  RecordingWriter::RemoveIfEmpty(folder_);
  EXPECT_TRUE(std::filesystem::exists(folder_)) << "something came";
}

TEST_F(RecordingWriterTest, LeavesNothingWhereNothingCame) {
  RecordingWriter::Create(folder_, Camera(), {}).value().reset();
  RecordingWriter::RemoveIfEmpty(folder_);
  EXPECT_FALSE(std::filesystem::exists(folder_));
}

TEST_F(RecordingWriterTest, RecordsIntoNoFolderThatHoldsAnything) {
  const auto refused = RecordingWriter::Create(temporary_.path() / "tiny", Camera(), {});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("is there already"), std::string::npos);
}

}  // namespace
}  // namespace plumbline
