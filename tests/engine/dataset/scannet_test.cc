// SPDX-License-Identifier: Apache-2.0
// ScanNet, as .sens and extracted, and Scan2CAD's alignments of its scans.
#include <cmath>

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "engine/dataset/sens_file.h"
#include "engine/dataset/sequence_formats.h"
#include "tests/engine/dataset/data_set_sample.h"

namespace plumbline {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kScan = "scans/scene0042_01";

class ScanNet : public DataSetSample {
 protected:
  void ExpectDepthInTheColourCamera(const Sequence& sequence, int frame, int i) {
    const auto depth = sequence.ReadDepth(frame);
    ASSERT_TRUE(depth.ok() && depth->has_value());
    ASSERT_EQ((*depth)->size(), cv::Size(160, 120));
    for (int x = 0; x < 160; ++x) {
      // Half the size, the same view: column x of colour lies in column (x - 0.5) / 2 of depth.
      const int column = static_cast<int>(std::lround((x - 0.5) / 2));
      const int seen = 2 * column;
      const int expected = seen < 16 ? 0 : 1000 + 10 * (seen / 16) + i;
      ASSERT_EQ((*depth)->at<std::uint16_t>(50, x), expected) << x;
    }
  }
};

TEST_F(ScanNet, SensIsReadFieldByField) {
  for (const std::string compression : {"1", "0"}) {
    ASSERT_NO_FATAL_FAILURE(Write("scannet_sens", compression));
    if (IsSkipped()) return;
    for (const std::string path : {"scans/scene0042_01", "scans/scene0042_01/scene0042_01.sens"}) {
      const auto sequence = Open(path);
      EXPECT_EQ(FindSequenceFormat(sequence->path())->name, "scannet");
      ASSERT_EQ(sequence->num_frames(), 4);
      EXPECT_THAT(sequence->warnings(), IsEmpty());
      EXPECT_EQ(sequence->camera(), (PinholeCamera{160, 120, 120, 120, 79.5, 59.5}));
      EXPECT_EQ(sequence->scene_file()->filename(), "scene0042_01_vh_clean_2.ply");
      EXPECT_EQ(*sequence->gravity_in_world(), Eigen::Vector3d(0, 0, -1));
      for (const int i : {3, 1, 0, 2}) {
        ExpectSampleImage(*sequence, i, i);
        ExpectDepthInTheColourCamera(*sequence, i, i);
        EXPECT_EQ(sequence->stamp_ns(i), 5000000000LL + 33333000LL * i);
        if (i != 2) {
          EXPECT_THAT(*sequence->world_from_cam(i), IsometryNear(SamplePose(i), 1e-4, 1e-6));
        }
      }
    }
  }
}

TEST_F(ScanNet, PosesOfMinusInfinityAreNone) {
  ASSERT_NO_FATAL_FAILURE(Write("scannet_sens"));
  if (IsSkipped()) return;
  EXPECT_FALSE(Open(kScan)->world_from_cam(2).has_value());
  EXPECT_EQ(NumPosedFrames(*Open(kScan)), 3);
}

TEST_F(ScanNet, StampsThatDoNotRiseBecome30Hz) {
  ASSERT_NO_FATAL_FAILURE(Write("scannet_sens", "1 zero"));
  if (IsSkipped()) return;
  const auto sequence = Open(kScan);
  ASSERT_EQ(sequence->num_frames(), 4);
  EXPECT_NEAR(sequence->rate_hz(), 30, 1e-3);
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("30 Hz")));
}

TEST_F(ScanNet, ExtractedIsReadFieldByFieldByNumber) {
  ASSERT_NO_FATAL_FAILURE(Write("scannet_extracted"));
  if (IsSkipped()) return;
  const auto sequence = Open("scans/scene0042_01/exported");
  EXPECT_EQ(FindSequenceFormat(sequence->path())->name, "scannet");
  ASSERT_EQ(sequence->num_frames(), 12);
  EXPECT_EQ(sequence->camera(), (PinholeCamera{160, 120, 120, 120, 79.5, 59.5}));
  for (const int i : {0, 3, 10}) {  // 10 comes after 9
    ExpectSampleImage(*sequence, i, i % 4);
    ExpectDepthInTheColourCamera(*sequence, i, i % 4);
    EXPECT_THAT(*sequence->world_from_cam(i), IsometryNear(SamplePose(i), 1e-6, 1e-8));
  }
  EXPECT_FALSE(sequence->world_from_cam(2).has_value());
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("1 frames without a pose")));
}

TEST_F(ScanNet, Scan2CadIsGroundTruthInTheScansFrame) {
  ASSERT_NO_FATAL_FAILURE(Write("scannet_sens"));
  if (IsSkipped()) return;
  ASSERT_NO_FATAL_FAILURE(Write("scan2cad"));
  ASSERT_NO_FATAL_FAILURE(Write("scannet_extracted"));
  for (const std::string path : {"scans/scene0042_01", "scans/scene0042_01/scene0042_01.sens",
                                 "scans/scene0042_01/exported"}) {
    SCOPED_TRACE(path);
    // The file lies at most two folders above that of the scan.
    if (path.ends_with("exported"))
      std::filesystem::rename(folder() / "full_annotations.json",
                              folder() / "scans/full_annotations.json");
    const auto sequence = Open(path);
    std::vector<std::string> warnings;
    const auto truth = ReadTruthOf(*sequence, warnings);
    ASSERT_TRUE(truth.ok()) << truth.error().message;
    ASSERT_TRUE(truth->has_value());
    EXPECT_THAT(warnings, IsEmpty());
    ASSERT_EQ((*truth)->instances.size(), 1u);
    const GroundTruthInstance& chair = (*truth)->instances[0];
    EXPECT_EQ(chair.model, "1a2b3c");
    EXPECT_EQ(chair.category, "chair");
    // On the floor at (2, 1), its front (+x of ours) along +y.
    Eigen::Isometry3d expected(Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitZ()));
    expected.translation() << 2, 1, 0;
    EXPECT_THAT(chair.world_from_object, IsometryNear(expected, 1e-6, 1e-9));
    // Along the front: twice bbox.z, stretched by scale.z; across: x; up: y.
    EXPECT_LT((*chair.size_m - Eigen::Vector3d(0.36, 0.4, 0.8)).norm(), 1e-9);
    EXPECT_NEAR(chair.scale, std::cbrt(0.5 * 0.8 * 0.6), 1e-12);
  }
}

TEST_F(ScanNet, ModelsOfScan2CadStandAsTheyWereBuilt) {
  ASSERT_NO_FATAL_FAILURE(Write("scannet_sens"));
  if (IsSkipped()) return;
  ASSERT_NO_FATAL_FAILURE(Write("scan2cad"));
  std::vector<std::string> warnings;
  const auto plain = ReadTruthOf(*Open("scans/scene0042_01"), warnings);
  ASSERT_TRUE(plain.ok() && plain->has_value());
  // As it is without frames, front along -z and up y, but for a place of its own.
  Eigen::Isometry3d object_from_file = Eigen::Isometry3d::Identity();
  object_from_file.linear() << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  object_from_file.translation() << 0, 0, 0.25;
  const auto lower =
      ReadTruthOf(*Open("scans/scene0042_01"), warnings, {{"1a2b3c", object_from_file}});
  object_from_file.translation().z() += 0.1;
  const auto higher =
      ReadTruthOf(*Open("scans/scene0042_01"), warnings, {{"1a2b3c", object_from_file}});
  ASSERT_TRUE(lower.ok() && higher.ok());
  const GroundTruthInstance& a = (*lower)->instances[0];
  const GroundTruthInstance& b = (*higher)->instances[0];
  EXPECT_LT(
      (a.world_from_object.linear() - (*plain)->instances[0].world_from_object.linear()).norm(),
      1e-9);
  EXPECT_LT((*a.size_m - Eigen::Vector3d(0.36, 0.4, 0.8)).norm(), 1e-9);
  // An origin 10 cm lower in the file, of a model that is 0.8 times as high.
  EXPECT_LT((a.world_from_object.translation() - b.world_from_object.translation() -
             Eigen::Vector3d(0, 0, 0.08))
                .norm(),
            1e-9);
}

TEST_F(ScanNet, OneThatWasCutOffIsRefusedInASentence) {
  ASSERT_NO_FATAL_FAILURE(Write("scannet_sens"));
  if (IsSkipped()) return;
  const auto file = folder() / "scans/scene0042_01/scene0042_01.sens";
  const auto size = std::filesystem::file_size(file);
  std::filesystem::resize_file(file, size - 100);
  EXPECT_THAT(WhyNot(kScan), HasSubstr("it ends within frame 3"));
  std::filesystem::resize_file(file, 200);
  EXPECT_THAT(WhyNot(kScan), HasSubstr("it ends before"));
  ASSERT_TRUE(WriteFileAtomically(file, std::string("\3\0\0\0", 4) + std::string(400, '\0')).ok());
  EXPECT_THAT(WhyNot(kScan), HasSubstr("version 3"));
}

}  // namespace
}  // namespace plumbline
