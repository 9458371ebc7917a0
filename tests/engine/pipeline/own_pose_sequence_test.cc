// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/own_pose_sequence.h"

#include <gtest/gtest.h>

#include "engine/base/file_lock.h"
#include "engine/dataset/growing_recording.h"
#include "engine/dataset/growing_sequence.h"
#include "engine/dataset/sequence_formats.h"
#include "tests/support/replayed_recording.h"
#include "tests/support/simulated_sequence.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

/// Frame 0 waits, 1 to 4 have a pose and as many points; a floor is found at 2 and known clearly
/// better at 4.
std::shared_ptr<const OwnPoses> Poses() {
  auto poses = std::make_shared<OwnPoses>();
  poses->frames.resize(5);
  poses->frames[0].waits_for = "waiting for rest";
  for (std::size_t i = 1; i < 5; ++i) {
    OwnPoseReport& frame = poses->frames[i];
    frame.ready = true;
    frame.world_from_cam = Eigen::Isometry3d(Eigen::Translation3d(0, static_cast<double>(i), 0));
    frame.cam_covariance.diagonal().setConstant(0.01 * static_cast<double>(i));
    frame.points_in_world.assign(i, {0, 0, 1});
    if (i >= 2) frame.floor = FloorReport{-1.3, i < 4 ? 0.04 : 0.02, 50};
  }
  return poses;
}

class OwnPoseSourceTest : public testing::Test {
 protected:
  OwnPoseSourceTest() { WriteTinySequence(folder_.path() / "sequence", {.frames = 5}); }
  std::shared_ptr<const Sequence> Open() const {
    return WithOwnPoses(OpenSequence(folder_.path() / "sequence").value(), Poses());
  }
  /// "gravity", "floor 0.04", "pose 3", "frame 3" ..
  static std::vector<std::string> All(FrameSource& source) {
    std::vector<std::string> all;
    while (true) {
      const auto packet = source.Next({});
      if (!packet.ok() || !*packet) return all;
      if (std::holds_alternative<GravityEstimate>(**packet)) all.emplace_back("gravity");
      if (const auto* floor = std::get_if<FloorEstimate>(&**packet))
        all.push_back("floor " + std::to_string(floor->std_m).substr(0, 4));
      if (const auto* found = std::get_if<PointEstimates>(&**packet))
        all.push_back("points " + std::to_string(found->points_in_world.size()));
      if (const auto* pose = std::get_if<PoseEstimate>(&**packet)) {
        all.push_back("pose " + std::to_string(pose->id.value));
        EXPECT_DOUBLE_EQ(pose->uncertainty.drift(0, 0), 0.01 * pose->id.value);
      }
      if (const auto* frame = std::get_if<FramePacket>(&**packet))
        all.push_back("frame " + std::to_string(frame->frame));
    }
  }
  TemporaryFolder folder_;
};

TEST_F(OwnPoseSourceTest, TellsTheFloorWhenItIsFoundAndWhenItIsBetterKnown) {
  OwnPoseSource source(Open());
  const std::vector<std::string> expected = {"gravity", "frame 0",    "pose 1",     "points 1",
                                             "frame 1", "pose 2",     "floor 0.04", "points 2",
                                             "frame 2", "pose 3",     "points 3",   "frame 3",
                                             "pose 4",  "floor 0.02", "points 4",   "frame 4"};
  EXPECT_EQ(All(source), expected);
  EXPECT_EQ(source.WaitsFor(0), "waiting for rest");
}

TEST_F(OwnPoseSourceTest, KnowsTheFloorAndThePointsAgainAfterASeek) {
  OwnPoseSource source(Open());
  source.Seek(4);
  const std::vector<std::string> expected = {"points 1",   "points 2", "points 3",
                                             "floor 0.04", "gravity",  "pose 4",
                                             "floor 0.02", "points 4", "frame 4"};
  EXPECT_EQ(All(source), expected);
}

TEST_F(OwnPoseSourceTest, TellsWhatALoopCorrectedBeforeTheFrameThatClosedIt) {
  auto poses = std::make_shared<OwnPoses>(*Poses());
  const auto moved = [](double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); };
  poses->corrections.push_back({3, 1, {moved(0), moved(7), moved(8)}});
  const auto sequence = WithOwnPoses(OpenSequence(folder_.path() / "sequence").value(), poses);
  OwnPoseSource source(sequence);
  const std::vector<std::string> expected = {
      "gravity",    "frame 0",  "pose 1",  "points 1",   "frame 1",  "pose 2",
      "floor 0.04", "points 2", "frame 2", "pose 1",     "pose 2",   "pose 3",
      "points 3",   "frame 3",  "pose 4",  "floor 0.02", "points 4", "frame 4"};
  EXPECT_EQ(All(source), expected);
  // One that begins later is told everything in the same order, so that points move alike.
  source.Seek(4);
  const std::vector<std::string> again = {"points 1", "points 2",   "pose 1", "pose 2",
                                          "points 3", "floor 0.04", "pose 4", "floor 0.02",
                                          "points 4", "frame 4"};
  EXPECT_EQ(All(source), again);
  source.Seek(3);
  while (true) {
    const auto packet = source.Next({});
    const auto* pose = std::get_if<PoseEstimate>(&**packet);
    if (pose == nullptr || pose->id.value != 2) continue;
    EXPECT_EQ(pose->epoch, 1);
    EXPECT_EQ(pose->world_from_cam.translation().x(), 8);
    break;
  }
}

TEST_F(OwnPoseSourceTest, TheSequenceHasTheFiltersWorld) {
  const auto sequence = Open();
  EXPECT_FALSE(sequence->world_from_cam(0).has_value());
  EXPECT_EQ(sequence->world_from_cam(3)->translation(), Eigen::Vector3d(0, 3, 0));
  EXPECT_EQ(*sequence->gravity_in_world(), Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ((*sequence->floor_in_world())[3], 1.3);
  EXPECT_EQ(sequence->ReadFrame(2)->world_from_cam->translation().y(), 2);
  EXPECT_NE(OwnPosesOf(*sequence), nullptr);
  EXPECT_EQ(GivenSequence(*sequence).world_from_cam(3)->translation().x(), 3);
  EXPECT_EQ(OwnPosesOf(GivenSequence(*sequence)), nullptr);
}

TEST(OwnPoseStore, FindsPosesAsTheyAreAskedFor) {
  const auto given = SimulatedSequence(Simulate({.seconds = 5, .points = 80, .pixel_noise_px = 0}));
  OwnPoseOptions options;
  options.loops = LoopUse::kCausal;
  const OwnPoses all = EstimateOwnPoses(given, given->num_frames(), options, {}).value();
  const auto sequence =
      WithOwnPoses(given, OwnPoseEstimator::Create(given, given->num_frames(), options).value());
  const auto store = OwnPoseStoreOf(*sequence);
  EXPECT_TRUE(store->grows());
  EXPECT_EQ(store->known(), 0);
  EXPECT_FALSE(sequence->world_from_cam(0).has_value());  // nobody asked yet
  store->Advance(59, {});
  EXPECT_GE(store->known(), 60);
  EXPECT_LT(store->known(), 80);  // of 100: not far ahead of who asks
  OwnPoseSource source(sequence);
  int frames = 0, poses = 0;
  while (true) {
    const auto packet = source.Next({});
    ASSERT_TRUE(packet.ok());
    if (!*packet) break;
    frames += std::holds_alternative<FramePacket>(**packet);
    const auto* pose = std::get_if<PoseEstimate>(&**packet);
    if (pose == nullptr) continue;
    ++poses;
    const auto& expected = all.frames[static_cast<std::size_t>(pose->id.value)];
    EXPECT_EQ(pose->world_from_cam.matrix(), expected.world_from_cam->matrix());
    EXPECT_EQ(pose->stamp_ns, given->stamp_ns(pose->id.value));
  }
  EXPECT_EQ(frames, 100);
  EXPECT_GT(poses, 40);
  EXPECT_EQ(store->known(), 100);
  EXPECT_EQ(OwnPosesOf(*sequence)->frames.size(), 100u);
  std::stop_source stopped;
  stopped.request_stop();
  store->Advance(1000, stopped.get_token());  // returns
}

TEST_F(OwnPoseSourceTest, ARecordingThatGrowsGetsThePosesOfTheWholeOne) {
  const auto simulated =
      SimulatedSequence(Simulate({.seconds = 5, .points = 80, .pixel_noise_px = 0}));
  const std::filesystem::path whole = folder_.path() / "whole", grown = folder_.path() / "grown";
  const SequenceFormat* format = FindSequenceFormat(folder_.path() / "sequence");
  ASSERT_TRUE(format->write(*simulated, whole, {}, {}).ok());
  const auto recorded = OpenSequence(whole).value();
  OwnPoseOptions options;
  options.loops = LoopUse::kCausal;
  const OwnPoses all = EstimateOwnPoses(recorded, recorded->num_frames(), options, {}).value();

  ReplayedRecording writer(whole, grown);
  writer.Add(2);
  const auto following = FollowRecording(grown, {}).value();
  const auto sequence = WithOwnPoses(
      following,
      OwnPoseEstimator::Create(following, std::numeric_limits<int>::max(), options).value());
  std::jthread recorder([&] {
    // Now the readings are far ahead, now just there, now the images come in bursts.
    for (int i = 0; writer.Add(1 + i % 4, i % 3 == 0 ? 300 : 12); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(i % 5));
    writer.End();
  });
  OwnPoseSource source(sequence);
  int frames = 0;
  while (true) {
    const auto packet = source.Next({});
    ASSERT_TRUE(packet.ok());
    if (!*packet) break;
    frames += std::holds_alternative<FramePacket>(**packet);
  }
  EXPECT_EQ(frames, recorded->num_frames());
  const auto found = OwnPosesOf(*sequence);
  ASSERT_EQ(found->frames.size(), all.frames.size());
  int poses = 0;
  for (std::size_t i = 0; i < all.frames.size(); ++i) {
    const OwnPoseReport &now = found->frames[i], &then = all.frames[i];
    EXPECT_EQ(now.waits_for, then.waits_for) << i;
    ASSERT_EQ(now.world_from_cam.has_value(), then.world_from_cam.has_value()) << i;
    if (!now.world_from_cam) continue;
    ++poses;
    EXPECT_EQ(now.world_from_cam->matrix(), then.world_from_cam->matrix()) << i;
    EXPECT_EQ(now.cam_covariance, then.cam_covariance) << i;
  }
  EXPECT_GT(poses, 30);
}

/// Finds many images, each with a track.
class ManyPoses : public OwnPoseFeed {
 public:
  explicit ManyPoses(std::size_t images) : images_(images) {}
  bool Next(const std::stop_token&) override {
    if (poses_.frames.size() >= images_) return false;
    poses_.frames.emplace_back().tracks.resize(1);
    poses_.frames.back().points_in_world.resize(1);
    return true;
  }
  int next() const override { return static_cast<int>(poses_.frames.size()); }
  const OwnPoses& poses() const override { return poses_; }
  void ForgetTracks(std::size_t image) override { poses_.frames[image].tracks.clear(); }

 private:
  const std::size_t images_;
  OwnPoses poses_;
};

TEST(OwnPoseStoreOfHours, KeepsTheTracksOfItsLastImagesOnly) {
  constexpr std::size_t kImages = OwnPoseStore::kTracksKept + 300;
  auto feed = std::make_unique<ManyPoses>(kImages);
  const ManyPoses& found = *feed;
  OwnPoseStore store(std::move(feed));
  store.Advance(kImages, {});
  const auto poses = store.Copy();
  ASSERT_EQ(poses->frames.size(), kImages);
  for (const OwnPoses* kept : {poses.get(), &found.poses()}) {
    std::size_t tracks = 0;
    for (const OwnPoseReport& frame : kept->frames) tracks += frame.tracks.size();
    EXPECT_EQ(tracks, OwnPoseStore::kTracksKept);
    EXPECT_FALSE(kept->frames.back().tracks.empty());
    EXPECT_EQ(kept->frames.front().points_in_world.size(), 1u) << "a mapper may begin anew";
  }
}

}  // namespace
}  // namespace plumbline
