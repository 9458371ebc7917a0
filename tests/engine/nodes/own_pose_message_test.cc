// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/own_pose_message.h"

#include <limits>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/recording/frame_codec.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

Calibration SomeCalibration() {
  Camera camera;
  camera.model = CameraModel::kEquidistant;
  camera.pinhole = {640, 480, 500.1, 501.2, 320.3, 240.4};
  camera.distortion = {0.1, -0.02, 0.003, 0.0004};
  camera.rate_hz = 20;
  camera.body_from_cam = Eigen::Translation3d(0.1, 0.2, 0.3) *
                         Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  camera.rolling_shutter_s = -0.02;
  ImuCalibration imu;
  imu.rate_hz = 100;
  imu.time_offset_s = -0.0123;
  imu.saturation_gyro_rad_s = 17.5;
  return {{{"camera", camera}}, imu};
}

ImuRecording Readings(int count) {
  ImuRecording imu;
  for (int i = 0; i < count; ++i)
    imu.samples.push_back(
        {1'000'000'007LL * i, {0.1 * i, 1.0 / 3, -1.0 * i}, {1.0 * i, 9.81, 1.0 / 7}});
  return imu;
}

PastCorrection SomeCorrection(int image, int epoch) {
  std::vector<TrajectoryMoves::Node> nodes;
  for (int i = 0; i < image; ++i) nodes.push_back({i, {i / 3.0, 2, 3}, {0.1 / 3, {i / 7.0, 5, 6}}});
  return {image, epoch, {0.1 / 7, {1.0 / 3, 2, 3}}, TrajectoryMoves(std::move(nodes))};
}

OwnPoses SomePoses(int count) {
  OwnPoses poses;
  poses.frames.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    OwnPoseReport& frame = poses.frames[static_cast<std::size_t>(i)];
    frame.vio.stamp_ns = i;
    frame.world_from_cam = Eigen::Isometry3d(Eigen::Translation3d(i, 1.0 / 3, -2));
    frame.ready = true;
    frame.points_in_world.assign(500, {1, static_cast<float>(i), 3});
  }
  poses.causal = false;
  poses.loops.epochs = 1;
  poses.loops.closures = {{2, 0, 2, 31, 0.5, 1.25, 0.875, 1}};
  poses.corrections.push_back(SomeCorrection(2, 1));
  return poses;
}

TEST(OwnPoseMessage, TellsOfTheImuAllThatAFilterNeedsInSeveralMessages) {
  const Calibration calibration = SomeCalibration();
  const ImuRecording imu = Readings(250'001);
  Calibration back;
  std::vector<ImuSample> samples;
  int messages = 0;
  for (bool complete = false; !complete; ++messages) {
    const auto message = ImuToWire(calibration, imu, static_cast<int>(samples.size()));
    const auto added = AddImuFromWire(message, back, samples);
    ASSERT_TRUE(added.ok()) << added.error().message;
    complete = *added;
  }
  EXPECT_EQ(messages, 3);
  ASSERT_EQ(samples.size(), imu.samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ASSERT_EQ(samples[i].stamp_ns, imu.samples[i].stamp_ns);
    ASSERT_EQ(samples[i].angular_velocity_rad_s, imu.samples[i].angular_velocity_rad_s);
    ASSERT_EQ(samples[i].specific_force_m_s2, imu.samples[i].specific_force_m_s2);
  }
  const Camera &sent = calibration.cameras[0].camera, &came = back.cameras.at(0).camera;
  EXPECT_EQ(came.model, sent.model);
  EXPECT_EQ(came.pinhole, sent.pinhole);
  EXPECT_EQ(came.distortion, sent.distortion);
  EXPECT_EQ(came.rate_hz, sent.rate_hz);
  EXPECT_EQ(came.rolling_shutter_s, sent.rolling_shutter_s);
  EXPECT_EQ(came.body_from_cam->matrix(), sent.body_from_cam->matrix());
  EXPECT_EQ(back.imu->rate_hz, 100);
  EXPECT_EQ(back.imu->time_offset_s, -0.0123);
  EXPECT_EQ(back.imu->saturation_gyro_rad_s, 17.5);
  EXPECT_FALSE(back.imu->saturation_accel_m_s2.has_value());
}

TEST(OwnPoseMessage, RefusesAnImuThatIsNone) {
  const wire::Imu whole = ImuToWire(SomeCalibration(), Readings(5), 0);
  const auto refused = [&](auto change) {
    wire::Imu message = whole;
    change(message);
    Calibration calibration;
    std::vector<ImuSample> samples;
    return !AddImuFromWire(message, calibration, samples).ok();
  };
  EXPECT_FALSE(refused([](wire::Imu&) {}));
  EXPECT_TRUE(refused([](wire::Imu& m) { m.set_stamps_ns(2, m.stamps_ns(1)); }));
  EXPECT_TRUE(refused([](wire::Imu& m) { m.mutable_readings()->RemoveLast(); }));
  EXPECT_TRUE(
      refused([](wire::Imu& m) { m.set_readings(3, std::numeric_limits<double>::infinity()); }));
  EXPECT_TRUE(refused([](wire::Imu& m) { m.set_total(4); }));
  EXPECT_TRUE(refused([](wire::Imu& m) { m.mutable_camera()->set_model(9); }));
  EXPECT_TRUE(refused([](wire::Imu& m) { m.mutable_camera()->mutable_pinhole()->set_width(0); }));
  EXPECT_TRUE(refused([](wire::Imu& m) { m.mutable_camera()->set_body_from_cam(0, 2); }));
  EXPECT_TRUE(refused([](wire::Imu& m) { m.mutable_noise()->set_rate_hz(0); }));
  EXPECT_TRUE(refused([](wire::Imu& m) { m.clear_stamps_ns(), m.clear_readings(); }))
      << "more was promised, and it would be asked for ever";
}

TEST(OwnPoseMessage, KeepsEveryBitOfThePoses) {
  const OwnPoses poses = SomePoses(2000);
  OwnPoses back;
  int messages = 0;
  for (bool complete = false; !complete; ++messages) {
    const auto message = OwnPosesToWire(poses, static_cast<int>(back.frames.size()));
    EXPECT_LT(message.ByteSizeLong(), 5'000'000u);
    const auto added = AddOwnPosesFromWire(message, back);
    ASSERT_TRUE(added.ok()) << added.error().message;
    complete = *added;
  }
  ASSERT_EQ(back.frames.size(), poses.frames.size());
  for (std::size_t i = 0; i < poses.frames.size(); ++i)
    ASSERT_EQ(EncodeOwnPose(back.frames[i]), EncodeOwnPose(poses.frames[i])) << i;
  EXPECT_FALSE(back.causal);
  EXPECT_EQ(ToJson(back.loops), ToJson(poses.loops));
  ASSERT_EQ(back.corrections.size(), 1u);
  EXPECT_EQ(back.corrections[0].image, 2);
  EXPECT_EQ(EncodeMoves(back.corrections[0]), EncodeMoves(poses.corrections[0]));
}

TEST(OwnPoseMessage, RefusesPosesThatAreNone) {
  const wire::OwnPoses whole = OwnPosesToWire(SomePoses(5), 0);
  const auto refused = [&](auto change) {
    wire::OwnPoses message = whole;
    change(message);
    OwnPoses poses;
    return !AddOwnPosesFromWire(message, poses).ok();
  };
  EXPECT_FALSE(refused([](wire::OwnPoses&) {}));
  EXPECT_TRUE(refused([](wire::OwnPoses& m) { m.mutable_records(1)->resize(7); }));
  EXPECT_TRUE(refused([](wire::OwnPoses& m) { m.set_loops("[1, 2"); }));
  EXPECT_TRUE(refused([](wire::OwnPoses& m) { m.mutable_corrections(0)->set_image(6); }));
  EXPECT_TRUE(refused([](wire::OwnPoses& m) { *m.add_corrections() = m.corrections(0); }));
  EXPECT_TRUE(refused([](wire::OwnPoses& m) { m.clear_records(); }));
}

TEST(OwnPoseMessage, TellsByNowWhatIsNotKnownYet) {
  auto all = std::make_shared<OwnPoses>(SomePoses(450));
  all->corrections.clear();
  for (int epoch = 1; epoch <= 20; ++epoch)
    all->corrections.push_back(SomeCorrection(20 * epoch, epoch));
  const OwnPoseStore store(all);
  OwnPoses known;
  int messages = 0;
  for (bool finding = true; finding; ++messages) {
    ASSERT_LT(messages, 10);
    wire::OwnPosesRequest request;
    request.set_from(static_cast<int>(known.frames.size()));
    request.set_corrections(static_cast<int>(known.corrections.size()));
    const auto added = AddOwnPosesByNow(OwnPosesByNow(store, request),
                                        static_cast<int>(known.frames.size()), known);
    ASSERT_TRUE(added.ok()) << added.error().message;
    finding = *added;
    if (!known.corrections.empty()) {
      EXPECT_LE(known.corrections.back().image, static_cast<int>(known.frames.size()));
    }
  }
  EXPECT_GT(messages, 2) << "not all in one";
  ASSERT_EQ(known.frames.size(), 450u);
  for (std::size_t i = 0; i < known.frames.size(); ++i)
    ASSERT_EQ(EncodeOwnPose(known.frames[i]), EncodeOwnPose(all->frames[i])) << i;
  ASSERT_EQ(known.corrections.size(), 20u);
  EXPECT_EQ(known.corrections[19].past.nodes().size(), 400u);
  EXPECT_EQ(EncodeMoves(known.corrections[19]), EncodeMoves(all->corrections[19]));
}

/// Three frames and their readings have come.
class ThreeFrames : public GrowingRecording {
 public:
  bool HasFrame(int frame) const override { return frame < 3; }
  bool WaitForFrame(int frame, const std::stop_token&) const override { return frame < 3; }
  std::vector<ImuSample> WaitForImu(std::size_t from, std::int64_t,
                                    const std::stop_token&) const override {
    auto samples = Readings(7).samples;
    return {samples.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(from, 7)),
            samples.end()};
  }
  std::int64_t CameNs(int) const override { return 0; }
  bool ended() const override { return true; }
};

TEST(OwnPoseMessage, TellsWhatHasBeenRecordedSince) {
  const TemporaryFolder folder;
  WriteTinySequence(folder.path() / "sequence", {.frames = 3});
  const auto sequence = OpenSequence(folder.path() / "sequence").value();
  wire::GrowthRequest known;
  known.set_frames(1);
  known.set_readings(5);
  const ThreeFrames growing;
  const wire::Growth growth = GrowthToWire(*sequence, &growing, known).value();
  EXPECT_THAT(growth.frame_stamps_ns(),
              testing::ElementsAre(sequence->stamp_ns(1), sequence->stamp_ns(2)));
  EXPECT_TRUE(growth.ended());
  std::vector<ImuSample> samples = Readings(5).samples;
  ASSERT_TRUE(AddGrowthFromWire(growth, samples).ok());
  ASSERT_EQ(samples.size(), 7u);
  EXPECT_EQ(samples[6].specific_force_m_s2, Readings(7).samples[6].specific_force_m_s2);
  EXPECT_FALSE(AddGrowthFromWire(growth, samples).ok()) << "the same again does not rise";
  // A player that was started again finds the recording ended.
  known.set_readings(kEveryReading);
  const wire::Growth rest = GrowthToWire(*sequence, nullptr, known).value();
  EXPECT_THAT(rest.frame_stamps_ns(),
              testing::ElementsAre(sequence->stamp_ns(1), sequence->stamp_ns(2)));
  EXPECT_TRUE(rest.ended());
}

}  // namespace
}  // namespace plumbline
