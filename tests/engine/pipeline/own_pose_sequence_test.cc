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
  // Stamps are those of images 1 and 2.
  TrajectoryMoves::Node first, second;
  first.stamp_ns = poses->frames[1].vio.stamp_ns = 1;
  second.stamp_ns = poses->frames[2].vio.stamp_ns = 2;
  first.corrected.position_in_world.x() = 7;
  second.corrected.position_in_world.x() = 8;
  poses->corrections.push_back({3, 1, {}, TrajectoryMoves({first, second})});
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

/// Finds many images, each with a track; every 100th one corrects the past.
class ManyPoses : public OwnPoseFeed {
 public:
  static constexpr int kStep = 100;

  explicit ManyPoses(int images) : images_(images) {}
  bool Next(const std::stop_token&) override { return ++image_ < images_; }
  OwnPoseReport TakeReport() override { return ReportOf(image_); }
  std::vector<PastCorrection> TakeCorrections() override {
    if (image_ == 0 || image_ % kStep != 0) return {};
    ++loops_.epochs;
    LoopClosure& closure = loops_.closures.emplace_back();
    closure.closed_image = image_;
    closure.epoch = loops_.epochs;
    return {CorrectionOf(image_, loops_.epochs)};
  }
  const LoopReport& loops() const override { return loops_; }

  static OwnPoseReport ReportOf(int image) {
    OwnPoseReport report;
    report.tracks.resize(1);
    report.points_in_world.resize(1);
    report.vio.stamp_ns = image;
    report.ready = image % 7 != 0;
    report.world_from_cam =
        Eigen::Isometry3d(Eigen::AngleAxisd(0.001 * image, Eigen::Vector3d(0.6, 0, 0.8)));
    report.world_from_cam->translation() = Eigen::Vector3d(0.01 * image, 1.0 / 3, 0);
    report.vio.world_from_body.translation() = Eigen::Vector3d(0.01 * image, 1.0 / 7, 0);
    const Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Random();
    report.cam_covariance = (root * root.transpose()).selfadjointView<Eigen::Lower>();
    return report;
  }
  static PastCorrection CorrectionOf(int image, int epoch) {
    TrajectoryMoves::Node first, last;
    last.stamp_ns = image;
    last.filter_position_in_world.x() = 0.01 * image;
    last.corrected = {0.01 * epoch, last.filter_position_in_world * 0.99};
    return {image, epoch, MoveTo(last.corrected, last.filter_position_in_world),
            TrajectoryMoves({first, last})};
  }

 private:
  const int images_;
  int image_ = -1;
  LoopReport loops_;
};

TEST(OwnPoseStoreOfHours, KeepsThePosesOfOldAndAllElseOfItsLastImages) {
  constexpr auto kTracks = static_cast<int>(OwnPoseStore::kTracksKept),
                 kReports = static_cast<int>(OwnPoseStore::kReportsKept);
  constexpr int kImages = kReports + 300;
  OwnPoseStore store(std::make_unique<ManyPoses>(kImages));
  store.Advance(kImages, {});
  EXPECT_EQ(store.known(), kImages);
  const auto poses = store.Copy();
  ASSERT_EQ(poses->frames.size(), std::size_t{kImages});
  int tracks = 0, points = 0;
  for (const OwnPoseReport& frame : poses->frames) {
    tracks += static_cast<int>(frame.tracks.size());
    points += static_cast<int>(frame.points_in_world.size());
  }
  EXPECT_EQ(tracks, kTracks);
  EXPECT_EQ(points, kReports);
  EXPECT_FALSE(poses->frames.back().tracks.empty());
  for (const int image : {0, 1, 120, 299, 300, kImages - 1}) {
    const OwnPoseReport &kept = poses->frames[static_cast<std::size_t>(image)],
                        told = ManyPoses::ReportOf(image);
    EXPECT_EQ(kept.world_from_cam->matrix(), told.world_from_cam->matrix());
    EXPECT_EQ(kept.vio.world_from_body.translation(), told.vio.world_from_body.translation());
    EXPECT_EQ(kept.cam_covariance, kept.cam_covariance.transpose());
    EXPECT_EQ(kept.vio.stamp_ns, image);
    EXPECT_EQ(store.At(image)->pose.has_value(), image % 7 != 0) << image;
  }

  const int corrections = static_cast<int>(poses->corrections.size());
  EXPECT_EQ(corrections, (kImages - 1) / ManyPoses::kStep);
  const auto last = static_cast<std::size_t>(corrections - 1);
  EXPECT_EQ(store.ImageOfCorrection(last), corrections * ManyPoses::kStep);
  EXPECT_FALSE(store.ImageOfCorrection(last + 1).has_value());
  EXPECT_TRUE(store.CorrectedPast(last - OwnPoseStore::kCorrectionsKept).empty()) << "let go of";
  const std::vector<PoseEstimate> past = store.CorrectedPast(last);
  EXPECT_EQ(past.size(), static_cast<std::size_t>(*store.ImageOfCorrection(last)) * 6 / 7);
  for (const std::size_t i : {std::size_t{0}, std::size_t{90}, std::size_t{17'000}}) {
    const int image = past[i].id.value;
    const auto told = ManyPoses::ReportOf(image);
    // What it was moved by when it was told, taken back.
    const Eigen::Isometry3d told_from_filter =
        image < ManyPoses::kStep
            ? Eigen::Isometry3d::Identity()
            : ManyPoses::CorrectionOf(image - image % ManyPoses::kStep, image / ManyPoses::kStep)
                  .present.AsIsometry();
    const Eigen::Isometry3d filter = told_from_filter.inverse() * *told.world_from_cam;
    const Eigen::Vector3d body =
        told_from_filter.inverse() * told.vio.world_from_body.translation();
    const Eigen::Isometry3d expected =
        ManyPoses::CorrectionOf(corrections * ManyPoses::kStep, corrections).past.At(image, body) *
        filter;
    EXPECT_TRUE(past[i].world_from_cam.isApprox(expected, 1e-9)) << image;
    EXPECT_EQ(past[i].epoch, corrections);
  }
}

TEST(OwnPoseStoreOfHours, TellsEachImageOnceToWhoeverKeepsThem) {
  constexpr int kImages = 250, kBefore = 120;
  OwnPoseStore store(std::make_unique<ManyPoses>(kImages));
  store.Advance(150, {});
  OwnPosesTaken taken(kBefore, 1);  // the file has these
  const auto first = taken.NowAndThen(store);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->first_image, std::size_t{kBefore});
  EXPECT_EQ(taken.NowAndThen(store), nullptr) << "not at once again";
  store.Advance(kImages, {});
  const auto rest = taken.Rest(store);
  EXPECT_EQ(rest->first_image, kBefore + first->poses.frames.size());
  EXPECT_EQ(first->poses.frames.size() + rest->poses.frames.size(),
            static_cast<std::size_t>(kImages - kBefore));
  EXPECT_EQ(first->poses.corrections.size() + rest->poses.corrections.size(), 1u);
  EXPECT_TRUE(rest->ended);
  EXPECT_TRUE(taken.Rest(store)->poses.frames.empty());
}

}  // namespace
}  // namespace plumbline
