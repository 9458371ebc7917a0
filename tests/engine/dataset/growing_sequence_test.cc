// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/growing_sequence.h"

#include <chrono>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include "engine/base/file_lock.h"
#include "engine/dataset/growing_recording.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

/// The images, camera and IMU of a tiny sequence, of which rows are written one by one.
class GrowingSequenceTest : public testing::Test {
 protected:
  GrowingSequenceTest() {
    WriteTinySequence(folder_, {.frames = 6});
    lock_ = FileLock::Acquire(folder_ / "color.csv").value();
  }

  void Image(int number) {
    Append("color.csv", std::to_string(10 + number) + ".5,color/" + FrameName(number) + ".jpg\n");
  }
  void Reading(double stamp_s) { Append("imu.csv", std::to_string(stamp_s) + ",1,2,3,4,5,6\n"); }
  void Append(const char* file, const std::string& text) const {
    std::ofstream(folder_ / file, std::ios::binary | std::ios::app) << text;
  }
  /// With two images and readings up to the first.
  std::shared_ptr<const Sequence> Follow() {
    Append("color.csv", "stamp_s,file\n");
    Append("imu.csv", "t,wx,wy,wz,ax,ay,az\n");
    Image(0);
    Image(1);
    Reading(10.4);
    Reading(10.6);
    auto sequence = FollowRecording(folder_, {});
    EXPECT_TRUE(sequence.ok()) << sequence.error().message;
    return *sequence;
  }

  TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path() / "recording";
  std::unique_ptr<FileLock> lock_;
};

TEST_F(GrowingSequenceTest, FramesAndReadingsComeAsTheirLinesEnd) {
  EXPECT_TRUE(IsBeingRecorded(folder_));
  const auto sequence = Follow();
  const GrowingRecording& growing = *GrowingRecordingOf(*sequence);
  EXPECT_EQ(sequence->num_frames(), 2);
  EXPECT_EQ(sequence->stamp_ns(1), 11'500'000'000);
  EXPECT_FALSE(growing.HasFrame(2));
  Append("color.csv", "12.5,color/00000");
  std::jthread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    EXPECT_EQ(sequence->num_frames(), 2) << "the line has not ended";
    Append("color.csv", "2.jpg\n");
    Reading(12.6);
  });
  EXPECT_TRUE(growing.WaitForFrame(2, {}));
  EXPECT_EQ(sequence->num_frames(), 3);
  EXPECT_EQ(sequence->ReadFrame(2)->image.cols, 64);
  EXPECT_GT(growing.CameNs(2), growing.CameNs(1));
  const auto readings = growing.WaitForImu(1, 12'500'000'000, {});
  ASSERT_EQ(readings.size(), 2u) << "from number 1 on";
  EXPECT_EQ(readings.back().stamp_ns, 12'600'000'000);
  EXPECT_EQ(readings.back().specific_force_m_s2, Eigen::Vector3d(4, 5, 6));
}

TEST_F(GrowingSequenceTest, EndsWhenTheWriterIsGoneHoweverItEnded) {
  const auto sequence = Follow();
  const GrowingRecording& growing = *GrowingRecordingOf(*sequence);
  EXPECT_FALSE(growing.ended());
  Image(2);
  Append("color.csv", "13.5,color/0000");  // cut off
  lock_.reset();
  EXPECT_FALSE(growing.WaitForFrame(3, {}));
  EXPECT_TRUE(growing.ended());
  EXPECT_EQ(sequence->num_frames(), 3) << "what was written before is there";
  EXPECT_EQ(growing.WaitForImu(0, 99'000'000'000, {}).size(), 2u) << "does not wait any more";
}

TEST_F(GrowingSequenceTest, LeavesOutWhatIsNoRowAndWhatIsNotLater) {
  const auto sequence = Follow();
  const GrowingRecording& growing = *GrowingRecordingOf(*sequence);
  Append("color.csv", "11.2,color/000004.jpg\nnonsense\n12,../../etc.jpg\n12,color/x.txt\n");
  Append("imu.csv", "10.7,1,2,3\n10.7,nan,2,3,4,5,6\n10.5,1,2,3,4,5,6\n");
  Image(3);
  Reading(10.8);
  EXPECT_TRUE(growing.WaitForFrame(2, {}));
  EXPECT_EQ(sequence->stamp_ns(2), 13'500'000'000);
  EXPECT_EQ(growing.WaitForImu(2, 10'700'000'000, {}).size(), 1u);
}

TEST_F(GrowingSequenceTest, DoesNotWaitForAnImuThatFellSilent) {
  const auto sequence = Follow();
  const GrowingRecording& growing = *GrowingRecordingOf(*sequence);
  EXPECT_EQ(growing.WaitForImu(0, 10'700'000'000, {}).size(), 2u)
      << "the second image is .8 s later than that";
}

TEST_F(GrowingSequenceTest, RefusesARecordingThatEndsTooSoon) {
  Append("color.csv", "stamp_s,file\n");
  Image(0);
  lock_.reset();
  const auto sequence = FollowRecording(folder_, {});
  ASSERT_FALSE(sequence.ok());
  EXPECT_EQ(sequence.error().code, ErrorCode::kNotFound);
  EXPECT_NE(sequence.error().message.find("ended before it had two images"), std::string::npos);
}

TEST_F(GrowingSequenceTest, RefusesARecordingWithoutAnImu) {
  for (int i = 0; i < 3; ++i) Image(i);
  const auto sequence = FollowRecording(folder_, {});
  ASSERT_FALSE(sequence.ok());
  EXPECT_NE(sequence.error().message.find("no readings of an IMU"), std::string::npos);
}

TEST_F(GrowingSequenceTest, WaitingEndsWhenItIsStopped) {
  std::stop_source stop;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    stop.request_stop();
  });
  WorkContext work;
  work.stop = stop.get_token();
  const auto sequence = FollowRecording(folder_, work);
  ASSERT_FALSE(sequence.ok());
  EXPECT_EQ(sequence.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace plumbline
