// SPDX-License-Identifier: Apache-2.0
// KITTI's raw data and odometry benchmark.
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/dataset/kitti_files.h"
#include "engine/dataset/kitti_tracklets.h"
#include "engine/dataset/sequence_formats.h"
#include "tests/engine/dataset/data_set_sample.h"

namespace plumbline {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kDrive = "2011_09_26/2011_09_26_drive_0005_sync";

class KittiRaw : public DataSetSample {};
class KittiOdometry : public DataSetSample {};

/// The camera 2 of the sample: rectified turn of 0.01 rad about z, 6 cm left of camera 0.
Eigen::Isometry3d CamFromVelo() {
  Eigen::Isometry3d cam0_from_velo = Eigen::Isometry3d::Identity();
  cam0_from_velo.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  cam0_from_velo.translation() << -0.05, -0.3, -0.1;
  return Eigen::Translation3d(0.06, 0, 0) *
         Eigen::Isometry3d(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ())) * cam0_from_velo;
}

Eigen::Isometry3d VeloFromImu() {
  return Eigen::Isometry3d(Eigen::Translation3d(-0.8, 0.3, -0.75));
}

/// Of frame i, in the world of the first packet.
Eigen::Isometry3d WorldFromImu(double i) {
  Eigen::Isometry3d pose(
      Eigen::AngleAxisd(std::numbers::pi / 4 + 0.05 * i, Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(-0.01, Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()));
  pose.translation() << 0.35 * i, 0.35 * i, 0.1 * i;
  return pose;
}

TEST_F(KittiRaw, IsReadFieldByField) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  EXPECT_EQ(FindSequenceFormat(folder() / kDrive)->name, "kitti-raw");
  const auto sequence = Open(kDrive);
  ASSERT_EQ(sequence->num_frames(), 5);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  EXPECT_EQ(sequence->calibration().cameras[0].name, "image_02");
  for (const int i : {4, 0, 2}) ExpectSampleImage(*sequence, i, i);
  EXPECT_EQ(*sequence->gravity_in_world(), Eigen::Vector3d(0, 0, -1));
}

TEST_F(KittiRaw, TheRectifiedProjectionIsTheCamera) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  // Not K and S, which are those before rectification.
  EXPECT_EQ(Open(kDrive)->camera(), (PinholeCamera{160, 48, 100, 100, 80, 24}));
}

TEST_F(KittiRaw, StampsKeepTheirNanosecondsAndPassFullMinutes) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  const auto sequence = Open(kDrive);
  // 2011-09-26 13:02:59.764389445 UTC
  EXPECT_EQ(sequence->stamp_ns(0), 1317042179'764389445);
  EXPECT_EQ(sequence->stamp_ns(3), 1317042180'064389445);
  EXPECT_EQ(ParseKittiStamp("2011-09-26 13:02:25.964389445"), 1317042145'964389445);
  EXPECT_EQ(ParseKittiStamp("2011-02-30 13:02:25.9"), std::nullopt);
  EXPECT_EQ(ParseKittiStamp("25.9"), std::nullopt);
}

TEST_F(KittiRaw, SynchronisedOxtsGivesPosesOfAForwardLeftUpBodyByNumber) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  const auto sequence = Open(kDrive);
  const Eigen::Isometry3d body_from_cam = (CamFromVelo() * VeloFromImu()).inverse();
  EXPECT_THAT(*sequence->calibration().cameras[0].camera.body_from_cam,
              IsometryNear(body_from_cam, 1e-6, 1e-9));
  for (int i = 0; i < 5; ++i)
    EXPECT_THAT(*sequence->world_from_cam(i),
                IsometryNear(WorldFromImu(i) * body_from_cam, 1e-6, 1e-4))
        << i;
  // The camera looks where the vehicle drives, and its y points down.
  EXPECT_GT(sequence->world_from_cam(0)->linear().col(2).dot(Eigen::Vector3d(1, 1, 0).normalized()),
            0.99);
  EXPECT_LT(sequence->world_from_cam(0)->linear()(2, 1), -0.99);
}

TEST_F(KittiRaw, OxtsIsTheImuInItsOwnAxesNotTheLevelledOnes) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  const auto imu = Open(kDrive)->ReadImu();
  ASSERT_TRUE(imu.ok());
  ASSERT_EQ(imu->samples.size(), 5u);
  EXPECT_LT((imu->samples[2].specific_force_m_s2 - Eigen::Vector3d(0.2, 0.2, 9.8)).norm(), 1e-9);
  EXPECT_LT((imu->samples[2].angular_velocity_rad_s - Eigen::Vector3d(0.01, 0.02, 0.06)).norm(),
            1e-9);
}

TEST_F(KittiRaw, WithoutColourTheLeftGreyCameraIsRead) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  std::filesystem::rename(folder() / kDrive / "image_02", folder() / kDrive / "image_00");
  const auto sequence = Open(kDrive);
  EXPECT_EQ(sequence->calibration().cameras[0].name, "image_00");
  // It stands 6 cm right of the colour one.
  const Eigen::Isometry3d cam0_from_velo = Eigen::Translation3d(-0.06, 0, 0) * CamFromVelo();
  EXPECT_THAT(
      *sequence->world_from_cam(2),
      IsometryNear(WorldFromImu(2) * (cam0_from_velo * VeloFromImu()).inverse(), 1e-6, 1e-4));
}

TEST_F(KittiRaw, UnsynchronisedPacketsJoinByStamp) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw", "extract 10"));
  if (IsSkipped()) return;
  const auto sequence = Open("2011_09_26/2011_09_26_drive_0005_extract");
  EXPECT_EQ(sequence->ReadImu()->samples.size(), 41u);
  const Eigen::Isometry3d body_from_cam = (CamFromVelo() * VeloFromImu()).inverse();
  for (int i = 0; i < 5; ++i)
    EXPECT_THAT(*sequence->world_from_cam(i),
                IsometryNear(WorldFromImu(i) * body_from_cam, 1e-4, 1e-3))
        << i;
}

TEST_F(KittiRaw, ImagesOfExtractThatAreNotRectifiedAreRefused) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw", "extract 10"));
  if (IsSkipped()) return;
  const std::string drive = "2011_09_26/2011_09_26_drive_0005_extract";
  cv::imwrite((folder() / drive / "image_02/data/0000000001.png").string(),
              cv::Mat(64, 180, CV_8UC3, cv::Scalar(1, 2, 3)));
  const auto image = Open(drive)->ReadRawImage(1);
  ASSERT_FALSE(image.ok());
  EXPECT_EQ(image.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(image.error().message, HasSubstr("not rectified"));
}

TEST_F(KittiRaw, TrackletsThatStandStillAreBoxesOfTheGroundTruth) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  const auto sequence = Open(kDrive);
  std::vector<std::string> warnings;
  const auto truth = ReadTruthOf(*sequence, warnings);
  ASSERT_TRUE(truth.ok() && truth->has_value());
  ASSERT_EQ((*truth)->instances.size(), 2u);  // the van drives
  EXPECT_THAT(warnings, testing::ElementsAre(HasSubstr("1 objects that move; kept apart")));
  ASSERT_EQ((*truth)->moving.size(), 1u);
  const MovingThing& van = (*truth)->moving[0];
  EXPECT_EQ(van.category, "car");
  ASSERT_GE(van.places.size(), 2u);
  EXPECT_GT((van.places.back().world_from_object.translation() -
             van.places.front().world_from_object.translation())
                .norm(),
            1);
  EXPECT_GT(van.places[1].frame, van.places[0].frame);
  const GroundTruthInstance& car = (*truth)->instances[0];
  EXPECT_EQ(car.id, "car_0");
  EXPECT_EQ(car.category, "car");
  EXPECT_FALSE(car.fine);
  EXPECT_LT((*car.size_m - Eigen::Vector3d(4.2, 1.8, 1.5)).norm(), 1e-9) << "length, width, height";
  Eigen::Isometry3d expected(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
  expected.translation() << 20, 8, -1.7;
  // Yaw about the velodyne's z, which is 1.3 degrees off the vertical.
  EXPECT_THAT(car.world_from_object, IsometryNear(expected, 0.05, 1e-4));
  const GroundTruthInstance& person = (*truth)->instances[1];
  EXPECT_EQ(person.category, "person");
}

TEST_F(KittiRaw, TheFloorIsThePlaneUnderThePath) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  const auto sequence = Open(kDrive);
  ASSERT_TRUE(sequence->floor_in_world().has_value());
  const Eigen::Vector4d floor = *sequence->floor_in_world();
  for (int i = 0; i < sequence->num_frames(); ++i) {
    const Eigen::Vector3d camera = sequence->world_from_cam(i)->translation();
    EXPECT_NEAR(floor.head<3>().dot(camera) + floor[3], 1.65, 3 * sequence->floor_std_m() + 1e-6);
  }
}

TEST_F(KittiRaw, ConvertedItKeepsItsBoxesAndItsImu) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  const auto sequence = Open(kDrive);
  ASSERT_TRUE(SequenceFormats().front().write(*sequence, folder() / "ours", {}, {}).ok());
  const auto ours = Open("ours");
  EXPECT_THAT(*ours->world_from_cam(3), IsometryNear(*sequence->world_from_cam(3), 1e-5, 1e-8));
  EXPECT_EQ(ours->ReadImu()->samples.size(), 5u);
  EXPECT_EQ(ours->stamp_ns(4), sequence->stamp_ns(4));
  const auto truth = ReadGroundTruth(*ours->ground_truth_file());
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  EXPECT_EQ(truth->instances.at(0).size_m->x(), 4.2);
}

TEST_F(KittiRaw, ConvertedToTheAslLayoutItKeepsItsImuAndItsPoses) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  const auto sequence = Open(kDrive);
  for (const SequenceFormat& format : SequenceFormats()) {
    if (format.name != "asl") continue;
    const auto written = format.write(*sequence, folder() / "asl", {}, {});
    ASSERT_TRUE(written.ok()) << written.error().message;
    EXPECT_EQ(written->poses, 5);
  }
  const auto asl = Open("asl");
  EXPECT_EQ(FindSequenceFormat(asl->path())->name, "asl");
  ASSERT_EQ(asl->num_frames(), 5);
  EXPECT_EQ(asl->camera(), sequence->camera());
  EXPECT_THAT(*asl->calibration().cameras[0].camera.body_from_cam,
              IsometryNear(*sequence->calibration().cameras[0].camera.body_from_cam, 1e-6, 1e-9));
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(asl->stamp_ns(i), sequence->stamp_ns(i));
    ExpectSampleImage(*asl, i, i);
    EXPECT_THAT(*asl->world_from_cam(i), IsometryNear(*sequence->world_from_cam(i), 1e-6, 1e-9));
    EXPECT_EQ(asl->ReadImu()->samples[static_cast<std::size_t>(i)].stamp_ns,
              sequence->ReadImu()->samples[static_cast<std::size_t>(i)].stamp_ns);
    EXPECT_LT((asl->ReadImu()->samples[static_cast<std::size_t>(i)].specific_force_m_s2 -
               sequence->ReadImu()->samples[static_cast<std::size_t>(i)].specific_force_m_s2)
                  .norm(),
              1e-9);
  }
}

TEST_F(KittiRaw, DamageIsASentence) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_raw"));
  if (IsSkipped()) return;
  const auto drive = folder() / kDrive;
  ASSERT_TRUE(WriteFileAtomically(drive / "oxts/data/0000000002.txt", "49.0 8.4").ok());
  EXPECT_THAT(Open(kDrive)->warnings(), Contains(HasSubstr("0000000002.txt")));
  EXPECT_FALSE(Open(kDrive)->world_from_cam(2).has_value());
  ASSERT_TRUE(WriteFileAtomically(drive / "tracklet_labels.xml",
                                  ReadFile(drive / "tracklet_labels.xml")->substr(0, 900))
                  .ok());
  EXPECT_THAT(ReadKittiTracklets(drive / "tracklet_labels.xml").error().message,
              HasSubstr("is not XML"));
  std::filesystem::remove(folder() / "2011_09_26/calib_cam_to_cam.txt");
  EXPECT_THAT(WhyNot(kDrive), HasSubstr("calib_cam_to_cam.txt"));
}

TEST_F(KittiOdometry, IsReadFieldByField) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_odometry"));
  if (IsSkipped()) return;
  const auto sequence = Open("dataset/sequences/04");
  EXPECT_EQ(FindSequenceFormat(sequence->path())->name, "kitti-odometry");
  ASSERT_EQ(sequence->num_frames(), 4);
  EXPECT_EQ(sequence->camera(), (PinholeCamera{160, 48, 100, 100, 80, 24}));
  for (const int i : {3, 1, 0, 2}) {
    ExpectSampleImage(*sequence, i, i);
    EXPECT_EQ(sequence->stamp_ns(i), 103736000LL * i);
  }
}

TEST_F(KittiOdometry, PosesAreOfTheLeftGreyCameraAndAreCarriedOverToTheColourOne) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_odometry"));
  if (IsSkipped()) return;
  const auto color = Open("dataset/sequences/04");
  for (int i = 0; i < 4; ++i) {
    // The colour camera stands 6 cm left of the grey one: P2's last column is 100 * 0.06.
    EXPECT_THAT(*color->world_from_cam(i),
                IsometryNear(SamplePose(i) * Eigen::Translation3d(-0.06, 0, 0), 1e-6, 1e-9));
  }
  std::filesystem::remove_all(folder() / "dataset/sequences/04/image_2");
  const auto grey = Open("dataset/sequences/04/");
  EXPECT_EQ(grey->calibration().cameras[0].name, "image_0");
  EXPECT_THAT(*grey->world_from_cam(2), IsometryNear(SamplePose(2), 1e-6, 1e-9));
  EXPECT_EQ(grey->ReadRawImage(2)->at<cv::Vec3b>(7, 9), cv::Vec3b(27, 27, 27));
}

TEST_F(KittiOdometry, TheVelodynesKeyMayHaveAnyName) {
  for (const std::string key : {"Tr", "Tr_velo_cam", "Tr_velo_to_cam"}) {
    ASSERT_NO_FATAL_FAILURE(Write("kitti_odometry", key));
    if (IsSkipped()) return;
    EXPECT_EQ(Open("dataset/sequences/04")->num_frames(), 4) << key;
  }
}

TEST_F(KittiOdometry, SequencesFrom11OnHaveNoPoses) {
  ASSERT_NO_FATAL_FAILURE(Write("kitti_odometry"));
  if (IsSkipped()) return;
  EXPECT_EQ(NumPosedFrames(*Open("dataset/sequences/11")), 0);
  ASSERT_TRUE(WriteFileAtomically(folder() / "dataset/sequences/11/calib.txt", "P1: 1 2 3\n").ok());
  EXPECT_THAT(WhyNot("dataset/sequences/11"), HasSubstr("'P0: ..'"));
}

}  // namespace
}  // namespace plumbline
