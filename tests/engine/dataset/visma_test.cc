// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/visma_sequence.h"

#include <cmath>

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "engine/dataset/visma_dataset.h"
#include "tests/engine/dataset/data_set_sample.h"

namespace plumbline {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Visma : public DataSetSample {};

TEST_F(Visma, IsReadFieldByFieldPackedOrNot) {
  for (const std::string packed : {"''", "packed"}) {
    ASSERT_NO_FATAL_FAILURE(Write("visma", packed));
    if (IsSkipped()) return;
    const auto sequence = Open("clutter1");
    EXPECT_EQ(FindSequenceFormat(sequence->path())->name, "visma");
    ASSERT_EQ(sequence->num_frames(), 4);
    EXPECT_THAT(sequence->warnings(), IsEmpty());
    EXPECT_EQ(sequence->camera(), (PinholeCamera{160, 96, 110, 111, 80, 48}));
    for (const int i : {3, 0, 2, 1}) {
      ExpectSampleImage(*sequence, i, i);
      EXPECT_THAT(*sequence->world_from_cam(i), IsometryNear(SamplePose(i), 1e-6, 1e-12));
    }
  }
}

TEST_F(Visma, StampsAreOrderedAsWholeNumbersNotAsFloats) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  const auto sequence = Open("clutter1");
  // As floats, all four are the same.
  EXPECT_EQ(static_cast<float>(sequence->stamp_ns(0)), static_cast<float>(sequence->stamp_ns(3)));
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(sequence->stamp_ns(i), 1512345678000000000 + 33333333LL * i);
}

TEST_F(Visma, StampsOfMicrosecondsAreToldByTheirSteps) {
  ASSERT_NO_FATAL_FAILURE(Write("visma", "'' %d 1000"));
  if (IsSkipped()) return;
  const auto sequence = Open("clutter1");
  EXPECT_NEAR(sequence->rate_hz(), 30, 0.01);
  EXPECT_NEAR(static_cast<double>(sequence->stamp_ns(3)), 1e8, 2e3);
}

TEST_F(Visma, PacketIBelongsToTheIthImageWhateverItsStamp) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  std::filesystem::remove(folder() / "clutter1/1512345678099999999.000000.png");
  const auto sequence = Open("clutter1");
  ASSERT_EQ(sequence->num_frames(), 3);
  EXPECT_THAT(*sequence->world_from_cam(2), IsometryNear(SamplePose(2), 1e-6, 1e-12));
  EXPECT_THAT(sequence->warnings(), ElementsAre(HasSubstr("3 images and 4 packets")));
}

TEST_F(Visma, BoxesBelongToTheImageOfTheirName) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  const auto sequence = Open("clutter1");
  EXPECT_TRUE(sequence->has_proposals());
  EXPECT_FALSE(sequence->ReadProposals(1)->has_value()) << "its file is missing";
  const auto proposals = sequence->ReadProposals(2);
  ASSERT_TRUE(proposals.ok() && proposals->has_value());
  ASSERT_EQ((*proposals)->size(), 1u);
  const Detection& box = (**proposals)[0];
  EXPECT_EQ(box.category, "chair");
  EXPECT_FLOAT_EQ(box.score, 0.7f) << "the first score is that of the best class";
  EXPECT_FLOAT_EQ(box.box.x0, 12);
  EXPECT_FLOAT_EQ(box.box.y1, 70.5);
}

TEST_F(Visma, GravityIsTheRotationOfMinusZ) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  EXPECT_LT((*Open("clutter1")->gravity_in_world() - Eigen::Vector3d(0, 1, 0)).norm(), 1e-12);
}

TEST_F(Visma, TheTruthOfTheScanComesIntoTheWorldOfTheRecording) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  std::vector<std::string> warnings;
  const auto truth = ReadTruthOf(*Open("clutter1"), warnings);
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  ASSERT_TRUE(truth->has_value());
  ASSERT_EQ((*truth)->instances.size(), 2u);
  EXPECT_THAT(warnings, Contains(HasSubstr("'gone_1'")));
  // The scan's z is up, and so is the world's that the alignment tells; the data set's gravity is
  // made up to be another.
  EXPECT_THAT(warnings, Contains(HasSubstr("more than 5 degrees")));
  const GroundTruthInstance& chair = (*truth)->instances[0];
  EXPECT_EQ(chair.id, "swivel_chair_0");
  EXPECT_EQ(chair.model, "swivel_chair") << "what stands before the last underscore";
  EXPECT_EQ(chair.category, "chair");
  Eigen::Isometry3d scan_from_world = Eigen::Isometry3d::Identity();
  scan_from_world.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  scan_from_world.translation() << 0.5, -1, 0.25;
  // In the scan it stands upright in our axes (z up), turned by 0.5 rad.
  Eigen::Isometry3d scan_from_object(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  scan_from_object.translation() << 1, 2, 3;
  EXPECT_THAT(chair.world_from_object,
              IsometryNear(scan_from_world.inverse() * scan_from_object, 1e-6, 1e-12));
  EXPECT_EQ((*truth)->instances[1].model, "Aeron");
}

TEST_F(Visma, ModelsStandAsTheyWereBuilt) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  std::vector<std::string> warnings;
  const auto plain = ReadTruthOf(*Open("clutter1"), warnings);
  // Built with +z of its file for its front, from an origin half a metre up and 20 cm aside.
  Eigen::Isometry3d object_from_file = Eigen::Isometry3d::Identity();
  object_from_file.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  object_from_file.translation() << 0, -0.2, 0.5;
  warnings.clear();
  const auto truth = ReadTruthOf(*Open("clutter1"), warnings, {{"swivel_chair", object_from_file}});
  ASSERT_TRUE(truth.ok() && truth->has_value());
  EXPECT_THAT(warnings, Contains(HasSubstr("no model 'Aeron' was built")));
  // Wherever a point of the file was placed, it is placed still.
  Eigen::Isometry3d upright_from_file = Eigen::Isometry3d::Identity();
  upright_from_file.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Eigen::Vector3d in_file(0.1, 0.7, -0.3);
  EXPECT_LT(((*truth)->instances[0].world_from_object * (object_from_file * in_file) -
             (*plain)->instances[0].world_from_object * (upright_from_file * in_file))
                .norm(),
            1e-9);
  EXPECT_THAT((*truth)->instances[1].world_from_object,
              IsometryNear((*plain)->instances[1].world_from_object, 1e-9, 1e-9));
}

TEST_F(Visma, WithoutTheAlignmentOfTheRecordingTheTruthStaysInTheScan) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  std::filesystem::remove(folder() / "RGBD/clutter1/fragments/result_alignment.json");
  std::vector<std::string> warnings;
  const auto truth = ReadTruthOf(*Open("clutter1"), warnings);
  ASSERT_TRUE(truth.ok() && truth->has_value());
  EXPECT_THAT(warnings, Contains(HasSubstr("in the frame of the scan")));
  EXPECT_LT(
      ((*truth)->instances[0].world_from_object.translation() - Eigen::Vector3d(1, 2, 3)).norm(),
      1e-12);
  EXPECT_LT(((*truth)->gravity_in_world - Eigen::Vector3d(0, 0, -1)).norm(), 1e-9);
}

TEST_F(Visma, ConvertedItKeepsItsProposalsAndItsTruth) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  const auto written =
      SequenceFormats().front().write(*Open("clutter1"), folder() / "ours", {}, {});
  ASSERT_TRUE(written.ok()) << written.error().message;
  const auto ours = Open("ours");
  EXPECT_FALSE(ours->ReadProposals(1)->has_value());
  EXPECT_FLOAT_EQ((**ours->ReadProposals(3))[0].score, 0.8f);
  EXPECT_EQ(ReadGroundTruth(*ours->ground_truth_file())->instances.size(), 2u);
}

TEST_F(Visma, ATruncatedFileIsRefused) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  const auto file = folder() / "clutter1/dataset";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_THAT(WhyNot("clutter1"), HasSubstr("truncated"));
}

}  // namespace
}  // namespace plumbline
