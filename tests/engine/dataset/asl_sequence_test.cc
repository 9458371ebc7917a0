// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/asl_sequence.h"

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/dataset/trajectory.h"
#include "engine/dataset/trajectory_writer.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

constexpr const char* kCamera = R"(%YAML:1.0
sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [1, 0, 0, 0.1, 0, 1, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]
rate_hz: 20
resolution: [64, 48]
camera_model: pinhole
intrinsics: [60, 61, 31.5, 23.5] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 2e-4, 2e-5]
)";

class AslLayout : public testing::Test {
 protected:
  void Write(const std::string& name, const std::string& text) {
    std::filesystem::create_directories((root_ / name).parent_path());
    ASSERT_TRUE(WriteFileAtomically(root_ / name, text).ok());
  }
  void WriteAll() {
    Write("mav0/cam0/sensor.yaml", kCamera);
    Write("mav0/cam0/data.csv",
          "#timestamp [ns],filename\n1403715273262142976,a.png\n1403715273312143104,b.png\n");
    Write("mav0/imu0/sensor.yaml",
          "%YAML:1.0\nrate_hz: 200\ngyroscope_noise_density: 1.7e-4 # rad / s\n");
    Write("mav0/imu0/data.csv", "#timestamp [ns],w,a\n1403715273262142976,0,0,0.07,9,0.1,-3.7\n");
    Write("mav0/state_groundtruth_estimate0/data.csv",
          "#timestamp,p,q\n1403715273262142976,1,2,3,0,0,0,1,0,0,0,0,0,0,0,0,0\n");
    std::filesystem::create_directories(root_ / "mav0/cam0/data");
    cv::imwrite((root_ / "mav0/cam0/data/a.png").string(),
                cv::Mat(48, 64, CV_8UC1, cv::Scalar(90)));
  }
  TemporaryFolder folder_;
  const std::filesystem::path root_ = folder_.path() / "sequence";
};

TEST_F(AslLayout, OpensWithCameraImuAndPosesOfTheCamera) {
  WriteAll();
  const auto opened = OpenSequence(root_);
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  const Sequence& sequence = **opened;
  EXPECT_EQ(sequence.num_frames(), 2);
  EXPECT_EQ(sequence.stamp_ns(1), 1403715273312143104);
  EXPECT_EQ(sequence.camera(), (PinholeCamera{64, 48, 60, 61, 31.5, 23.5}));
  EXPECT_EQ(sequence.calibration().imu->gyro_noise_density, 1.7e-4);
  EXPECT_EQ(sequence.ReadImu()->samples.size(), 1u);
  // Half a turn about z: the arm of (0.1, 0.2, 0.3) points the other way.
  EXPECT_LT((sequence.world_from_cam(0)->translation() - Eigen::Vector3d(0.9, 1.8, 3.3)).norm(),
            1e-12);
  EXPECT_FALSE(sequence.world_from_cam(1).has_value());
  EXPECT_TRUE(sequence.ReadRawImage(0).ok());
  EXPECT_THAT(sequence.ReadRawImage(1).error().message, HasSubstr("b.png"));
}

TEST_F(AslLayout, RefusesAnotherCameraAndATruncatedFile) {
  WriteAll();
  Write("mav0/cam0/sensor.yaml",
        std::string(kCamera).replace(std::string(kCamera).find("pinhole"), 7, "omni"));
  EXPECT_THAT(OpenSequence(root_).error().message, HasSubstr("omni"));
  Write("mav0/cam0/sensor.yaml", std::string(kCamera).substr(0, 120));
  EXPECT_THAT(OpenSequence(root_).error().message, HasSubstr("sensor.yaml"));
}

TEST_F(AslLayout, LeavesOutImagesOutsideOfItAndPosesBeyondReason) {
  WriteAll();
  Write("mav0/cam0/data.csv", "1403715273262142976,../../../a.png\n1403715273312143104,b.png\n");
  Write("mav0/state_groundtruth_estimate0/data.csv",
        "1403715273312143104,1e300,2,3,0,0,0,1,0,0,0,0,0,0,0,0,0\n");
  const auto opened = OpenSequence(root_);
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  EXPECT_EQ((*opened)->num_frames(), 1);
  EXPECT_FALSE((*opened)->world_from_cam(0).has_value());
  EXPECT_THAT((*opened)->warnings(),
              testing::ElementsAre(HasSubstr("outside of the folder data/"), HasSubstr("1000 km")));
}

TEST(TrajectoryWriter, WhatIsWrittenIsReadBack) {
  TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "T.txt";
  WrittenPose pose;
  pose.stamp_ns = 1403636579763555584;
  pose.world_from_sensor.linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  pose.world_from_sensor.translation() << 1, -2, 0.5;
  pose.covariance = PoseCovariance::Random();
  const WrittenPose poses[] = {pose};
  ASSERT_TRUE(WriteTrajectory(file, "world_from_body", poses).ok());
  ASSERT_TRUE(WriteCovariances(CovarianceFileOf(file), "world_from_body", poses).ok());
  const auto read = ReadTrajectory(file, Eigen::Isometry3d::Identity());
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->poses.at(0).stamp_ns, pose.stamp_ns);
  EXPECT_THAT(read->poses[0].world_from_cam, IsometryNear(pose.world_from_sensor, 1e-6, 1e-8));
  const auto covariances = ReadCovariances(folder.path() / "T.covariance.csv");
  ASSERT_TRUE(covariances.ok());
  EXPECT_EQ(covariances->rows.at(0).stamp_ns, pose.stamp_ns);
  EXPECT_LT((covariances->rows.at(0).covariance - pose.covariance).norm(), 1e-8);
}

}  // namespace
}  // namespace plumbline
