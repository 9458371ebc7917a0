// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/bop_sequence.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "tests/engine/dataset/data_set_sample.h"

namespace plumbline {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kScene = "sample/train_real/000012";

class BopScene : public DataSetSample {
 protected:
  void Change(const char* image, const char* key, const nlohmann::json& value) {
    const auto file = folder() / kScene / "scene_camera.json";
    nlohmann::json json = ReadJson(file).value();
    json[image][key] = value;
    ASSERT_TRUE(WriteJson(file, json).ok());
  }
};

TEST_F(BopScene, IsReadFieldByFieldWithKeysThatAreNotPadded) {
  ASSERT_NO_FATAL_FAILURE(Write("bop_scene"));
  if (IsSkipped()) return;
  const auto sequence = Open(kScene);
  EXPECT_EQ(FindSequenceFormat(sequence->path())->name, "bop");
  ASSERT_EQ(sequence->num_frames(), 4);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  EXPECT_EQ(sequence->camera(), (PinholeCamera{160, 120, 140, 141, 79, 59})) << "row by row";
  const int numbers[] = {0, 1, 2, 10};
  for (const int i : {3, 1, 0, 2}) {
    ExpectSampleImage(*sequence, i, numbers[i] % 4);
    EXPECT_NEAR(static_cast<double>(sequence->stamp_ns(i)), numbers[i] * 1e9 / 30, 1);
  }
}

TEST_F(BopScene, DepthTimesItsScaleIsMillimetres) {
  ASSERT_NO_FATAL_FAILURE(Write("bop_scene"));
  if (IsSkipped()) return;
  const auto sequence = Open(kScene);
  for (int i = 0; i < 3; ++i) ExpectSampleDepth(*sequence, i, i);
}

TEST_F(BopScene, PosesAreFromWorldToCameraInMillimetres) {
  ASSERT_NO_FATAL_FAILURE(Write("bop_scene"));
  if (IsSkipped()) return;
  const auto sequence = Open(kScene);
  EXPECT_THAT(*sequence->world_from_cam(1), IsometryNear(SamplePose(1), 1e-6, 1e-9));
  EXPECT_THAT(*sequence->world_from_cam(3), IsometryNear(SamplePose(10), 1e-6, 1e-9));
}

TEST_F(BopScene, TheTruthOfAllImagesIsOneInstanceAnObject) {
  ASSERT_NO_FATAL_FAILURE(Write("bop_scene"));
  if (IsSkipped()) return;
  std::vector<std::string> warnings;
  const auto truth = ReadTruthOf(*Open(kScene), warnings);
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  ASSERT_EQ((*truth)->instances.size(), 2u);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("does not tell gravity")));
  const GroundTruthInstance& object = (*truth)->instances[0];
  EXPECT_EQ(object.model, "obj_000003");
  // Models have their origin in the middle of their box: ours stands 70 mm below.
  Eigen::Isometry3d expected(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()));
  expected.translation() << 1, 2, 0.5 - 0.07;
  EXPECT_THAT(object.world_from_object, IsometryNear(expected, 1e-6, 1e-9));
  EXPECT_LT((*object.size_m - Eigen::Vector3d(0.1, 0.12, 0.14)).norm(), 1e-12);
  // Its box is 10 mm off the middle of x.
  EXPECT_NEAR((*truth)->instances[1].world_from_object.translation().x(), 2.01, 1e-9);
}

TEST_F(BopScene, ModelsStandAsTheyWereBuilt) {
  ASSERT_NO_FATAL_FAILURE(Write("bop_scene"));
  if (IsSkipped()) return;
  std::vector<std::string> warnings;
  Eigen::Isometry3d object_from_file = Eigen::Isometry3d::Identity();
  object_from_file.linear() << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  object_from_file.translation() << 0.01, 0.02, 0.07;
  const auto truth = ReadTruthOf(*Open(kScene), warnings, {{"obj_000003", object_from_file}});
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  Eigen::Isometry3d world_from_file(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()));
  world_from_file.translation() << 1, 2, 0.5;
  const GroundTruthInstance& object = (*truth)->instances[0];
  EXPECT_THAT(object.world_from_object,
              IsometryNear(world_from_file * object_from_file.inverse(), 1e-6, 1e-9));
  EXPECT_LT((*object.size_m - Eigen::Vector3d(0.12, 0.1, 0.14)).norm(), 1e-12);
}

TEST_F(BopScene, ACamKBesideACamModelIsAnError) {
  ASSERT_NO_FATAL_FAILURE(Write("bop_scene"));
  if (IsSkipped()) return;
  Change("1", "cam_model", {{"projection_params", {140, 79, 59}}});
  EXPECT_THAT(WhyNot(kScene), HasSubstr("image 1 has both cam_K and cam_model"));
}

TEST_F(BopScene, ImagesOfAnotherCameraAreLeftOut) {
  ASSERT_NO_FATAL_FAILURE(Write("bop_scene"));
  if (IsSkipped()) return;
  Change("2", "cam_K", {150, 0, 79, 0, 141, 59, 0, 0, 1});
  const auto sequence = Open(kScene);
  EXPECT_EQ(sequence->num_frames(), 3);
  EXPECT_THAT(sequence->warnings(), Contains(HasSubstr("another camera")));
}

TEST_F(BopScene, WithoutPosesOfTheCamerasThereIsNoTruthInWorld) {
  ASSERT_NO_FATAL_FAILURE(Write("bop_scene"));
  if (IsSkipped()) return;
  for (const char* image : {"0", "1", "2", "10"}) Change(image, "cam_R_w2c", nullptr);
  std::vector<std::string> warnings;
  const auto sequence = Open(kScene);
  EXPECT_EQ(NumPosedFrames(*sequence), 0);
  const auto truth = ReadTruthOf(*sequence, warnings);
  ASSERT_TRUE(truth.ok());
  EXPECT_FALSE(truth->has_value());
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("cam_R_w2c")));
}

}  // namespace
}  // namespace plumbline
