// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/folder_source.h"

#include <gmock/gmock.h>

#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Folder : public testing::Test {
 protected:
  Folder() {
    WriteTinySequence(root_, {.frames = 3, .edges = true, .proposals = true});
    WriteText(root_ / "imu.csv",
              "-0.05,0,0,0,0,0,9.8\n0.1,1,0,0,0,0,9.8\n0.15,2,0,0,0,0,9.8\n0.35,3,0,0,0,0,9.8\n");
  }
  FolderSource Open() { return FolderSource(OpenSequence(root_).value()); }

  /// "gravity 0", "pose 2 at 200" ..: kind, number, milliseconds.
  static std::string Words(const Packet& packet) {
    const auto at = [](std::int64_t stamp_ns) {
      return " at " + std::to_string(stamp_ns / 1000000);
    };
    struct Speller {
      const decltype(at)& when;
      std::string operator()(const GravityEstimate& p) const {
        return "gravity" + when(p.stamp_ns);
      }
      std::string operator()(const FloorEstimate& p) const { return "floor" + when(p.stamp_ns); }
      std::string operator()(const PointEstimates& p) const { return "points" + when(p.stamp_ns); }
      std::string operator()(const ImuSample& p) const { return "imu" + when(p.stamp_ns); }
      std::string operator()(const PoseEstimate& p) const {
        return "pose " + std::to_string(p.id.value) + when(p.stamp_ns);
      }
      std::string operator()(const FramePacket& p) const {
        return "frame " + std::to_string(p.frame) + when(p.stamp_ns);
      }
    };
    return std::visit(Speller{at}, packet);
  }
  static std::vector<std::string> All(FrameSource& source) {
    std::vector<std::string> all;
    while (true) {
      const auto packet = source.Next({});
      EXPECT_TRUE(packet.ok()) << packet.error().message;
      if (!packet.ok() || !packet.value()) return all;
      all.push_back(Words(**packet));
    }
  }

  TemporaryFolder folder_;
  const std::filesystem::path root_ = folder_.path() / "sequence";
};

TEST_F(Folder, YieldsPacketsInTheOrderOfTimeAndThenTheEnd) {
  FolderSource source = Open();
  const auto all = All(source);
  EXPECT_THAT(all, ElementsAre("gravity at -50", "floor at -50", "imu at -50", "pose 0 at 0",
                               "frame 0 at 0", "imu at 100", "pose 1 at 100", "frame 1 at 100",
                               "imu at 150", "pose 2 at 200", "frame 2 at 200", "imu at 350"));
  EXPECT_FALSE(source.Next({}).value()) << "the end stays the end";
}

TEST_F(Folder, GoesOnAfterAnyFrame) {
  FolderSource source = Open();
  source.Seek(2);
  EXPECT_THAT(All(source), ElementsAre("gravity at -50", "floor at -50", "imu at 150",
                                       "pose 2 at 200", "frame 2 at 200", "imu at 350"));
  source.Seek(1);
  EXPECT_THAT(All(source),
              ElementsAre("imu at 100", "pose 1 at 100", "frame 1 at 100", "imu at 150",
                          "pose 2 at 200", "frame 2 at 200", "imu at 350"));
}

TEST_F(Folder, GivesEveryPartOfAFrameByItsNumber) {
  const FolderSource source = Open();
  EXPECT_EQ(source.num_frames(), 3);
  const FramePacket packet = source.Frame(1);
  EXPECT_EQ(packet.content->Image().value().size(), cv::Size(64, 48));
  EXPECT_EQ(packet.content->RawImage().value().size(), cv::Size(64, 48));
  EXPECT_EQ(packet.content->Edges().value()->probability.at<unsigned char>(5, 11), 200);
  EXPECT_EQ(packet.content->Proposals().value()->size(), 1u);
  EXPECT_FALSE(packet.content->Depth().value());
  const auto pose = source.Pose(1);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->id, PoseId{1});
  EXPECT_EQ(pose->world_from_cam.translation().x(), 1);
  EXPECT_TRUE(pose->uncertainty.drift.isZero() && pose->uncertainty.own.isZero())
      << "given, not estimated";
  EXPECT_EQ(pose->epoch, 0);
  EXPECT_EQ(source.calibration().cameras[packet.camera].camera.pinhole.width, 64);
}

TEST_F(Folder, StopsWhereAskedToAndSaysWhatIsBroken) {
  FolderSource source = Open();
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(source.Next(stop.get_token()).error().code, ErrorCode::kCancelled);
  WriteText(root_ / "imu.csv", "broken\n");
  FolderSource broken = Open();
  EXPECT_THAT(broken.Next({}).error().message, HasSubstr("imu.csv"));
  FolderSource without_imu(OpenSequence(root_).value(), false);
  EXPECT_EQ(All(without_imu).size(), 8u);
}

TEST_F(Folder, WithoutPosesNamesTheRemedy) {
  EXPECT_TRUE(CheckHasPoses(*OpenSequence(root_).value()).ok());
  std::filesystem::remove(root_ / "trajectory.txt");
  const Status status = CheckHasPoses(*OpenSequence(root_).value());
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, HasSubstr("--poses FILE"));
  EXPECT_THAT(status.error().message, HasSubstr(root_.string()));
  const std::filesystem::path other = folder_.path() / "poses.txt";
  WriteText(other, "900 0 0 0 0 0 0 1\n");
  const auto elsewhere = OpenSequence(root_, {.poses = other}).value();
  EXPECT_THAT(CheckHasPoses(*elsewhere, other).error().message, HasSubstr("the same clock"));
  FolderSource source = Open();
  EXPECT_THAT(All(source), testing::Not(testing::Contains(HasSubstr("pose"))));
}

}  // namespace
}  // namespace plumbline
