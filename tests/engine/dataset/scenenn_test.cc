// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/scenenn_sequence.h"

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "tests/engine/dataset/data_set_sample.h"

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class SceneNn : public DataSetSample {};

Eigen::Isometry3d SceneNnPose(int i) {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitY()));
  pose.translation() << 0.2 * i, 0, 0;
  return pose;
}

TEST_F(SceneNn, IsReadFieldByFieldFromImageOne) {
  ASSERT_NO_FATAL_FAILURE(Write("scenenn"));
  if (IsSkipped()) return;
  std::filesystem::remove(folder() / "123/timestamp.txt");
  const auto sequence = Open("123");
  EXPECT_EQ(FindSequenceFormat(sequence->path())->name, "scenenn");
  ASSERT_EQ(sequence->num_frames(), 4);
  EXPECT_EQ(sequence->camera(), (PinholeCamera{640, 480, 544.47329, 544.47329, 320, 240}));
  EXPECT_EQ(sequence->scene_file()->filename(), "123.ply");
  EXPECT_FALSE(sequence->gravity_in_world().has_value());
  for (const int i : {3, 0, 1, 2}) {
    // The k-th pose of the log is that of image k, local to world.
    EXPECT_THAT(*sequence->world_from_cam(i), IsometryNear(SceneNnPose(i), 1e-6, 1e-8));
    ExpectSampleImage(*sequence, i, i);
    ExpectSampleDepth(*sequence, i, i);
    EXPECT_NEAR(static_cast<double>(sequence->stamp_ns(i)), i * 1e9 / 30, 1);
  }
}

TEST_F(SceneNn, StampsJoinByTheImagesNumber) {
  ASSERT_NO_FATAL_FAILURE(Write("scenenn"));
  if (IsSkipped()) return;
  const auto sequence = Open("123");
  ASSERT_EQ(sequence->num_frames(), 3);  // image 3 has no row
  EXPECT_EQ(sequence->stamp_ns(1), 41'000'000);
  EXPECT_EQ(sequence->stamp_ns(2), 121'000'000);
  ExpectSampleImage(*sequence, 2, 3);
  EXPECT_THAT(*sequence->world_from_cam(2), IsometryNear(SceneNnPose(3), 1e-6, 1e-8));
  EXPECT_THAT(sequence->warnings(), ElementsAre(HasSubstr("no row for 1 images")));
}

TEST_F(SceneNn, TheTrajectoryMayLieBesideTheScenes) {
  ASSERT_NO_FATAL_FAILURE(Write("scenenn"));
  if (IsSkipped()) return;
  std::filesystem::create_directories(folder() / "trajectory");
  std::filesystem::rename(folder() / "123/trajectory.log",
                          folder() / "trajectory/123_trajectory.log");
  EXPECT_EQ(NumPosedFrames(*Open("123/")), 3);
}

TEST_F(SceneNn, LabelsAreReadFromTheAnnotation) {
  ASSERT_NO_FATAL_FAILURE(Write("scenenn"));
  if (IsSkipped()) return;
  const auto labels = ReadSceneNnLabels(*SceneNnAnnotation(folder() / "123"));
  ASSERT_TRUE(labels.ok()) << labels.error().message;
  ASSERT_EQ(labels->size(), 3u);
  EXPECT_EQ((*labels)[1].id, 7);
  EXPECT_EQ((*labels)[1].nyu_class, "chair");
  EXPECT_EQ(CategoryOfNyu("sofa"), "couch");
  EXPECT_EQ(CategoryOfNyu("floor"), std::nullopt);
  ASSERT_TRUE(WriteFileAtomically(folder() / "123/123.xml", "<annotation><label").ok());
  EXPECT_THAT(ReadSceneNnLabels(folder() / "123/123.xml").error().message, HasSubstr("is not XML"));
}

TEST_F(SceneNn, ATruncatedLogIsRefused) {
  ASSERT_NO_FATAL_FAILURE(Write("scenenn"));
  if (IsSkipped()) return;
  const auto file = folder() / "123/trajectory.log";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 30);
  EXPECT_THAT(WhyNot("123"), HasSubstr("truncated"));
}

}  // namespace
}  // namespace plumbline
