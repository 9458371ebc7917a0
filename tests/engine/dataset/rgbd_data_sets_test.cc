// SPDX-License-Identifier: Apache-2.0
// 7-Scenes, TUM RGB-D and ICL-NUIM, and converting them.
#include <cmath>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "engine/base/files.h"
#include "engine/dataset/sequence_formats.h"
#include "tests/engine/dataset/data_set_sample.h"

namespace plumbline {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class SevenScenes : public DataSetSample {};
class TumRgbd : public DataSetSample {};
class IclNuim : public DataSetSample {};
class Conversion : public DataSetSample {};

TEST_F(SevenScenes, IsReadFieldByField) {
  ASSERT_NO_FATAL_FAILURE(Write("seven_scenes"));
  if (IsSkipped()) return;
  EXPECT_EQ(FindSequenceFormat(folder() / "redkitchen/seq-01")->name, "7-scenes");
  const auto sequence = Open("redkitchen/seq-01");
  ASSERT_EQ(sequence->num_frames(), 4);
  EXPECT_EQ(sequence->camera(), (PinholeCamera{640, 480, 585, 585, 320, 240}));
  EXPECT_NEAR(sequence->rate_hz(), 30, 1e-6);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  EXPECT_FALSE(sequence->gravity_in_world().has_value());
  for (const int i : {3, 0, 2, 1}) {  // at random
    EXPECT_NEAR(static_cast<double>(sequence->stamp_ns(i)), i * 1e9 / 30, 1);
    EXPECT_THAT(*sequence->world_from_cam(i), IsometryNear(SamplePose(i), 1e-6, 1e-8));
    ExpectSampleImage(*sequence, i, i);
  }
}

TEST_F(SevenScenes, DepthOf65535IsNone) {
  ASSERT_NO_FATAL_FAILURE(Write("seven_scenes"));
  if (IsSkipped()) return;
  const auto sequence = Open("redkitchen/seq-01");
  for (int i = 0; i < 4; ++i) ExpectSampleDepth(*sequence, i, i);
}

TEST_F(SevenScenes, MissingFramesLeaveAGapAndPosesThatAreNoneAreLeftOut) {
  ASSERT_NO_FATAL_FAILURE(Write("seven_scenes"));
  if (IsSkipped()) return;
  const auto sequence_folder = folder() / "redkitchen/seq-01";
  std::filesystem::remove(sequence_folder / "frame-000001.color.png");
  ASSERT_TRUE(WriteFileAtomically(sequence_folder / "frame-000002.pose.txt",
                                  "nan nan nan nan\nnan nan nan nan\nnan nan nan nan\n0 0 0 1\n")
                  .ok());
  const auto sequence = Open("redkitchen/seq-01");
  ASSERT_EQ(sequence->num_frames(), 3);
  EXPECT_NEAR(static_cast<double>(sequence->stamp_ns(1)), 2e9 / 30, 1);
  EXPECT_FALSE(sequence->world_from_cam(1).has_value());
  EXPECT_TRUE(sequence->world_from_cam(2).has_value());
  EXPECT_THAT(sequence->warnings(), ElementsAre(HasSubstr("frame-000002.pose.txt")));
}

TEST_F(SevenScenes, OfAWholeSceneOneSequenceIsToBeChosen) {
  ASSERT_NO_FATAL_FAILURE(Write("seven_scenes"));
  if (IsSkipped()) return;
  EXPECT_THAT(WhyNot("redkitchen"), HasSubstr("seq-01"));
}

TEST_F(SevenScenes, TheRealKitchenLaidOutAsThatIsTheKitchen) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  if (std::system("/usr/bin/python3 -c 'import cv2' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-opencv, which lays the kitchen out, is not installed";
  ASSERT_NO_FATAL_FAILURE(Write("kitchen_as_seven_scenes",
                                (*shared / "data/kitchen").string() + " 4", "/usr/bin/python3"));
  const auto sequence = Open("seq-01");
  const auto kitchen = OpenSequence(*shared / "data/kitchen");
  ASSERT_TRUE(kitchen.ok());
  ASSERT_EQ(sequence->num_frames(), 4);
  for (int i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    const auto image = sequence->ReadRawImage(i), other = (*kitchen)->ReadRawImage(10 * i);
    ASSERT_TRUE(image.ok() && other.ok());
    EXPECT_EQ(cv::norm(*image, *other, cv::NORM_INF), 0);
    const auto depth = sequence->ReadDepth(i), other_depth = (*kitchen)->ReadDepth(10 * i);
    ASSERT_TRUE(depth.ok() && depth->has_value() && other_depth.ok() && other_depth->has_value());
    EXPECT_EQ(cv::norm(**depth, **other_depth, cv::NORM_INF), 0);
    EXPECT_THAT(*sequence->world_from_cam(i),
                IsometryNear(*(*kitchen)->world_from_cam(10 * i), 1e-5, 1e-7));
    EXPECT_NEAR(static_cast<double>(sequence->stamp_ns(i)),
                static_cast<double>((*kitchen)->stamp_ns(10 * i)), 1e3);
  }
}

TEST_F(TumRgbd, IsReadFieldByField) {
  ASSERT_NO_FATAL_FAILURE(Write("tum_rgbd"));
  if (IsSkipped()) return;
  EXPECT_EQ(FindSequenceFormat(folder() / "rgbd_dataset_freiburg3_sample")->name, "tum-rgbd");
  const auto sequence = Open("rgbd_dataset_freiburg3_sample");
  ASSERT_EQ(sequence->num_frames(), 4);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  EXPECT_EQ(sequence->camera(), (PinholeCamera{640, 480, 535.4, 539.2, 320.1, 247.6}));
  EXPECT_EQ(*sequence->gravity_in_world(), Eigen::Vector3d(0, 0, -1));
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(sequence->stamp_ns(i), 1341845688'100000000 + 33333000LL * i);
    ExpectSampleImage(*sequence, i, i);
  }
}

TEST_F(TumRgbd, DepthIs5000ToTheMetreAndJoinsWithin20Milliseconds) {
  ASSERT_NO_FATAL_FAILURE(Write("tum_rgbd"));
  if (IsSkipped()) return;
  const auto sequence = Open("rgbd_dataset_freiburg3_sample");
  for (const int i : {0, 1, 3}) ExpectSampleDepth(*sequence, i, i);
  const auto early = sequence->ReadDepth(2);
  ASSERT_TRUE(early.ok());
  EXPECT_FALSE(early->has_value());
}

TEST_F(TumRgbd, QuaternionsAreXyzwAndPosesLieBetweenTheirNeighbours) {
  ASSERT_NO_FATAL_FAILURE(Write("tum_rgbd"));
  if (IsSkipped()) return;
  const auto sequence = Open("rgbd_dataset_freiburg3_sample");
  for (int i = 0; i < 3; ++i)
    EXPECT_THAT(*sequence->world_from_cam(i), IsometryNear(SamplePose(i), 1e-4, 2e-6)) << i;
  EXPECT_FALSE(sequence->world_from_cam(3).has_value()) << "the truth has ended before";
}

TEST_F(TumRgbd, TheFoldersNameTellsTheCamera) {
  ASSERT_NO_FATAL_FAILURE(Write("tum_rgbd", "rgbd_dataset_freiburg1_desk"));
  if (IsSkipped()) return;
  const auto first = Open("rgbd_dataset_freiburg1_desk");
  EXPECT_EQ(first->calibration().cameras[0].camera.pinhole.fx, 517.3);
  EXPECT_THAT(first->calibration().cameras[0].camera.distortion,
              ElementsAre(0.2624, -0.9531, -0.0054, 0.0026, 1.1633));
  std::filesystem::rename(folder() / "rgbd_dataset_freiburg1_desk", folder() / "desk");
  EXPECT_EQ(Open("desk")->camera(), (PinholeCamera{640, 480, 525, 525, 319.5, 239.5}));
  ASSERT_TRUE(WriteFileAtomically(folder() / "desk/calibration.txt", "726 727 354 187\n").ok());
  EXPECT_EQ(Open("desk")->camera(), (PinholeCamera{640, 480, 726, 727, 354, 187}));
  ASSERT_TRUE(WriteFileAtomically(folder() / "desk/calibration.txt", "726 727 354\n").ok());
  EXPECT_THAT(WhyNot("desk"), HasSubstr("calibration.txt"));
}

TEST_F(TumRgbd, ImagesOutsideOfItAreLeftOut) {
  ASSERT_NO_FATAL_FAILURE(Write("tum_rgbd"));
  if (IsSkipped()) return;
  ASSERT_TRUE(WriteFileAtomically(folder() / "rgbd_dataset_freiburg3_sample/rgb.txt",
                                  "1341845688.1 rgb/1341845688.100000.png\n"
                                  "1341845689.1 ../../other.png\n")
                  .ok());
  const auto sequence = Open("rgbd_dataset_freiburg3_sample");
  EXPECT_EQ(sequence->num_frames(), 1);
  EXPECT_THAT(sequence->warnings(), ElementsAre(HasSubstr("outside of the folder")));
}

TEST_F(IclNuim, IsReadFieldByFieldByTheNumberOfTheImage) {
  ASSERT_NO_FATAL_FAILURE(Write("icl_nuim"));
  if (IsSkipped()) return;
  const auto sequence = Open("living_room_traj2_frei_png");
  EXPECT_EQ(FindSequenceFormat(sequence->path())->name, "icl-nuim");
  ASSERT_EQ(sequence->num_frames(), 12);
  EXPECT_EQ(sequence->camera(), (PinholeCamera{640, 480, 481.20, 480.00, 319.5, 239.5}));
  for (const int i : {0, 3, 10}) {  // 10.png comes after 9.png
    ExpectSampleImage(*sequence, i, i % 4);
    ExpectSampleDepth(*sequence, i, i % 4);
    EXPECT_NEAR(static_cast<double>(sequence->stamp_ns(i)), i * 1e9 / 30, 1);
  }
  EXPECT_FALSE(sequence->world_from_cam(0).has_value()) << "the truth begins with image 1";
}

TEST_F(IclNuim, PosesOfTheMirroredRendererAreRightHanded) {
  ASSERT_NO_FATAL_FAILURE(Write("icl_nuim"));
  if (IsSkipped()) return;
  const auto sequence = Open("living_room_traj2_frei_png");
  for (int i = 1; i < 12; ++i)
    EXPECT_THAT(*sequence->world_from_cam(i), IsometryNear(SamplePose(i), 1e-4, 2e-6)) << i;
  // The renderer's world has y up; the mirrored one y down.
  EXPECT_EQ(*sequence->gravity_in_world(), Eigen::Vector3d(0, 1, 0));
}

/// The two show the same, frame by frame.
void ExpectSame(const Sequence& a, const Sequence& b, double rotation_deg, double translation_m) {
  ASSERT_EQ(a.num_frames(), b.num_frames());
  EXPECT_EQ(a.camera(), b.camera());
  for (int i = 0; i < a.num_frames(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(a.stamp_ns(i), b.stamp_ns(i));
    const auto one = a.ReadFrame(i), other = b.ReadFrame(i);
    ASSERT_TRUE(one.ok() && other.ok());
    EXPECT_EQ(cv::norm(one->image, other->image, cv::NORM_INF), 0);
    const auto depth = a.ReadDepth(i), other_depth = b.ReadDepth(i);
    ASSERT_TRUE(depth.ok() && other_depth.ok());
    ASSERT_EQ(depth->has_value(), other_depth->has_value());
    if (depth->has_value()) {
      EXPECT_EQ(cv::norm(**depth, **other_depth, cv::NORM_INF), 0);
    }
    ASSERT_EQ(one->world_from_cam.has_value(), other->world_from_cam.has_value());
    if (one->world_from_cam) {
      EXPECT_THAT(*one->world_from_cam,
                  IsometryNear(*other->world_from_cam, rotation_deg, translation_m));
    }
  }
}

TEST_F(Conversion, ToOurLayoutAndBackLosesNothing) {
  ASSERT_NO_FATAL_FAILURE(Write("tum_rgbd"));
  if (IsSkipped()) return;
  const auto original = Open("rgbd_dataset_freiburg3_sample");
  for (const SequenceFormat& format : SequenceFormats()) {
    if (format.write == nullptr || format.name == "asl") continue;  // which has no depth
    SCOPED_TRACE(format.name);
    const auto out = folder() / std::string(format.name);
    const auto written = format.write(*original, out, {}, {});
    ASSERT_TRUE(written.ok()) << written.error().message;
    EXPECT_EQ(written->frames, 4);
    EXPECT_EQ(written->skipped, 0);
    EXPECT_EQ(FindSequenceFormat(out)->name, format.name);
    ExpectSame(*original, *Open(std::string(format.name)), 1e-5, 1e-8);
    EXPECT_THAT(format.write(*original, out, {}, {}).error().message,
                HasSubstr("is there already"));
  }
}

TEST_F(Conversion, UndistortsWhatHasDepthAndSkipsWhatCannotBeRead) {
  ASSERT_NO_FATAL_FAILURE(Write("tum_rgbd", "rgbd_dataset_freiburg1_desk"));
  if (IsSkipped()) return;
  std::filesystem::resize_file(folder() / "rgbd_dataset_freiburg1_desk/rgb/1341845688.133333.png",
                               100);
  const auto original = Open("rgbd_dataset_freiburg1_desk");
  const auto written = SequenceFormats().front().write(*original, folder() / "ours", {}, {});
  ASSERT_TRUE(written.ok()) << written.error().message;
  EXPECT_EQ(written->frames, 3);
  EXPECT_EQ(written->skipped, 1);
  EXPECT_THAT(written->warnings, Contains(HasSubstr("1341845688.133333.png")));
  const auto ours = Open("ours");
  EXPECT_THAT(ours->calibration().cameras[0].camera.distortion, IsEmpty());
  EXPECT_EQ(cv::norm(ours->ReadFrame(2)->image, original->ReadFrame(3)->image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(*ours->ReadDepth(2).value(), *original->ReadDepth(3).value(), cv::NORM_INF),
            0);
}

TEST_F(Conversion, OfRealEurocKeepsImagesImuCameraAndPoses) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  const auto euroc = OpenSequence(*shared / "data/vio/euroc_v101_micro");
  ASSERT_TRUE(euroc.ok()) << euroc.error().message;
  const auto imu = (*euroc)->ReadImu();
  ASSERT_TRUE(imu.ok());
  for (const SequenceFormat& format : SequenceFormats()) {
    if (format.name != "plumbline" && format.name != "asl") continue;
    SCOPED_TRACE(format.name);
    const auto written = format.write(**euroc, folder() / std::string(format.name), {}, {});
    ASSERT_TRUE(written.ok()) << written.error().message;
    const auto copy = Open(std::string(format.name));
    ASSERT_EQ(copy->num_frames(), (*euroc)->num_frames());
    const Camera &a = copy->calibration().cameras[0].camera,
                 &b = (*euroc)->calibration().cameras[0].camera;
    EXPECT_EQ(a.pinhole, b.pinhole);
    EXPECT_EQ(a.distortion, b.distortion);
    EXPECT_THAT(*a.body_from_cam, IsometryNear(*b.body_from_cam, 1e-6, 1e-9));
    for (int i = 0; i < copy->num_frames(); i += 10) {
      EXPECT_EQ(copy->stamp_ns(i), (*euroc)->stamp_ns(i));
      EXPECT_EQ(cv::norm(*copy->ReadRawImage(i), *(*euroc)->ReadRawImage(i), cv::NORM_INF), 0);
      ASSERT_EQ(copy->world_from_cam(i).has_value(), (*euroc)->world_from_cam(i).has_value());
      if (copy->world_from_cam(i)) {
        EXPECT_THAT(*copy->world_from_cam(i),
                    IsometryNear(*(*euroc)->world_from_cam(i), 1e-5, 1e-8));
      }
    }
    const auto copied = copy->ReadImu();
    ASSERT_TRUE(copied.ok());
    ASSERT_EQ(copied->samples.size(), imu->samples.size());
    for (std::size_t i = 0; i < imu->samples.size(); i += 50) {
      EXPECT_EQ(copied->samples[i].stamp_ns, imu->samples[i].stamp_ns);
      EXPECT_LT(
          (copied->samples[i].specific_force_m_s2 - imu->samples[i].specific_force_m_s2).norm(),
          1e-9);
    }
  }
}

}  // namespace
}  // namespace plumbline
