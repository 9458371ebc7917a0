// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/crop_comparer.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/dataset/ground_truth.h"
#include "engine/dataset/sequence.h"
#include "engine/geometry/angles.h"
#include "engine/synthetic/sequence_writer.h"
#include "tests/support/furniture_models.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

PosedShape Turned(const CadModel& model, const Eigen::Isometry3d& cam_from_object, double angle) {
  const Eigen::Vector3d axis(model.center().x(), model.center().y(), 0);
  return {model.id, cam_from_object * Eigen::Translation3d(axis) *
                        Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
                        Eigen::Translation3d(-axis)};
}

class CropComparerTest : public testing::Test {
 protected:
  CropComparerTest() : database_(MakeFurnitureDatabase()), crops_(database_) {
    camera_.width = 320;
    camera_.height = 240;
    camera_.fx = camera_.fy = 300;
    camera_.cx = 160;
    camera_.cy = 120;
    image_ = cv::Mat(240, 320, CV_8UC3);
    cv::randu(image_, 60, 120);
    cv::GaussianBlur(image_, image_, {}, 3);
  }
  /// Upright, its middle `depth` metres before the camera.
  PosedShape Before(const char* name, double depth) const {
    const CadModel& model = database_->model(*database_->Find(name));
    PosedShape shape{model.id};
    shape.cam_from_object.linear() = (Eigen::Matrix3d() << 0, -1, 0, 0, 0, -1, 1, 0, 0).finished();
    shape.cam_from_object.translation() =
        Eigen::Vector3d(0, 0, depth) - shape.cam_from_object.linear() * model.center();
    return shape;
  }

  std::shared_ptr<const ModelDatabase> database_;
  CropComparer crops_;
  PinholeCamera camera_;
  cv::Mat image_;
};

TEST_F(CropComparerTest, JudgesNothingThatHardlyShows) {
  PosedShape behind = Before("chair", 2), aside = Before("chair", 2);
  behind.cam_from_object.translation().z() -= 4;
  aside.cam_from_object.translation().x() += 30;
  const PosedShape shapes[] = {Before("chair", 2), behind, aside};
  const auto likeness = crops_.Compare(image_, camera_, {}, shapes);
  ASSERT_EQ(likeness.size(), 3u);
  EXPECT_TRUE(likeness[0]);
  EXPECT_FALSE(likeness[1]);
  EXPECT_FALSE(likeness[2]);
  const PosedShape far[] = {Before("chair", 40)};
  EXPECT_FALSE(crops_.Compare(image_, camera_, {}, far)[0]);
}

TEST_F(CropComparerTest, AShapeBehindSomethingIsNotJudged) {
  const PosedShape shapes[] = {Before("chair", 2)};
  EXPECT_FALSE(
      crops_.Compare(image_, camera_, {cv::Mat(120, 160, CV_32F, cv::Scalar(1)), 0.05}, shapes)[0]);
  EXPECT_TRUE(
      crops_.Compare(image_, camera_, {cv::Mat(120, 160, CV_32F, cv::Scalar(3)), 0.05}, shapes)[0]);
}

TEST_F(CropComparerTest, GivesTheSameAgainWhateverElseIsAsked) {
  const PosedShape one[] = {Before("chair", 2)};
  const auto first = crops_.Compare(image_, camera_, {}, one);
  const PosedShape other[] = {Before("table", 3), Before("armchair", 1.5)};
  crops_.Compare(image_, camera_, {}, other);
  EXPECT_EQ(crops_.Compare(image_, camera_, {}, one), first);
}

/// Pictures of a furnished room by the ray tracer, which knows nothing of this.
TEST(CropsOfARoom, TheTrueShapeAndSideLookMostAlike) {
  SyntheticOptions options;
  options.seed = 3;
  options.frames = 10;
  options.rate_hz = 1;
  options.width = 480;
  options.height = 360;
  options.light_rays = 8;
  options.light_spacing = 4;
  options.samples_per_pixel = 2;
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteSyntheticSequence(options, folder.path() / "room", {}).ok());
  const auto sequence = OpenSequence(folder.path() / "room");
  ASSERT_TRUE(sequence.ok());
  const auto database = ModelDatabase::Load(folder.path() / "room" / "models");
  const auto truth = ReadGroundTruth(folder.path() / "room" / "ground_truth.json");
  ASSERT_TRUE(database.ok() && truth.ok());
  CropComparer crops(*database);
  int turned = 0, turned_right = 0, other = 0, other_right = 0;
  for (int frame = 0; frame < options.frames; ++frame) {
    const auto image = (*sequence)->ReadFrame(frame);
    const auto mask = cv::imread(
        (folder.path() / "room" / "masks" / ("00000" + std::to_string(frame) + ".png")).string(),
        cv::IMREAD_UNCHANGED);
    const Eigen::Isometry3d cam_from_world = (*sequence)->world_from_cam(frame)->inverse();
    for (std::size_t i = 0; i < truth->instances.size(); ++i) {
      const GroundTruthInstance& instance = truth->instances[i];
      if (cv::countNonZero(mask == static_cast<double>(i + 1)) < 4000) continue;
      const CadModel& model = (*database)->model(*(*database)->Find(instance.model));
      const Eigen::Isometry3d cam_from_object = cam_from_world * instance.world_from_object;
      std::vector<PosedShape> shapes = {Turned(model, cam_from_object, 0)};
      if (model.symmetry.order == 1)
        shapes.push_back(Turned(model, cam_from_object, std::numbers::pi));
      const std::size_t turns = shapes.size();
      for (const ModelId label : (*database)->OfCategory(model.category))
        if (label != model.id) shapes.push_back({label, cam_from_object});
      const auto likeness = crops.Compare(image->image, (*sequence)->camera(), {}, shapes);
      for (std::size_t k = 1; k < shapes.size(); ++k) {
        if (!likeness[0] || !likeness[k]) continue;
        (k < turns ? turned : other) += 1;
        (k < turns ? turned_right : other_right) += *likeness[0] > *likeness[k];
      }
    }
  }
  RecordProperty("half_turns", std::to_string(turned_right) + " of " + std::to_string(turned));
  RecordProperty("shapes", std::to_string(other_right) + " of " + std::to_string(other));
  ASSERT_GE(turned, 15);
  ASSERT_GE(other, 15);
  EXPECT_GE(turned_right, 0.85 * turned) << turned;
  EXPECT_GE(other_right, 0.85 * other) << other;
}

}  // namespace
}  // namespace plumbline
