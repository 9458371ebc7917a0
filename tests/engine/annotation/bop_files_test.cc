// SPDX-License-Identifier: Apache-2.0
// What BOP counts, against boxes whose projection is known, and what its loaders look for.

#include "engine/annotation/bop_files.h"

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/annotation/instance_masks.h"
#include "engine/annotation/scaled_models.h"
#include "engine/base/files.h"
#include "engine/models/mesh_file.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

/// A sequence of 64x48 pixels (f 60, centre 31.5, 23.5) and panels before its first camera: boxes
/// 1 cm thick, whose near face is the silhouette.
class BopFiles : public testing::Test {
 protected:
  void SetUp() override { WriteTinySequence(folder_.path() / "walk", {.frames = 2}); }

  void Open() {
    auto sequence = OpenSequence(folder_.path() / "walk");
    ASSERT_TRUE(sequence.ok()) << sequence.error().message;
    sequence_ = *sequence;
  }
  /// A panel of this width and height [m] whose near face is at depth `z`, its middle on the axis.
  void AddPanel(float width, float height, double z) {
    CadModel model;
    model.name = "panel" + std::to_string(models_.size());
    model.category = "tv";
    model.mesh = MakeBox({-width / 2, -height / 2, 0}, {width / 2, height / 2, 0.01f});
    models_.push_back(model);
    AnnotatedInstance instance;
    instance.id = model.name + "_0";
    instance.model = model.name;
    instance.scan_from_object =
        ScanFromCam(document_, *sequence_, 0).value() * Eigen::Translation3d(0, 0, z);
    document_.instances.push_back(instance);
  }
  /// As measured in the first frame, in millimetres.
  void WriteDepth(const cv::Mat& depth) const {
    std::filesystem::create_directories(folder_.path() / "walk" / "depth");
    ASSERT_TRUE(cv::imwrite((folder_.path() / "walk" / "depth" / "000000.png").string(), depth));
  }
  void Export(std::vector<int> frames = {0}) {
    const auto models = ModelDatabase::FromModels(models_);
    const ExchangeInputs inputs{models.get(), sequence_.get(), std::move(frames)};
    const Status written = WriteBop(document_, inputs, Bop(), {});
    ASSERT_TRUE(written.ok()) << written.error().message;
  }
  std::filesystem::path Bop() const { return folder_.path() / "bop"; }
  std::filesystem::path Scene() const { return Bop() / "test" / "000000"; }
  nlohmann::json Info(int instance) const {
    return ReadJson(Scene() / "scene_gt_info.json").value()["0"][instance];
  }
  cv::Mat Mask(const char* kind, const char* name) const {
    return cv::imread((Scene() / kind / name).string(), cv::IMREAD_UNCHANGED);
  }

  TemporaryFolder folder_;
  std::shared_ptr<const Sequence> sequence_;
  AnnotationDocument document_;
  std::vector<CadModel> models_;
};

TEST_F(BopFiles, WhatLiesOutsideTheImageCountsAsInCalcGtInfo) {
  Open();
  // 60 * 3.04 / 2 = 91.2 pixels about 31.5: centres -14 to 77 are 92 of them, 64 in the image;
  // 60 * 1 / 2 = 30 about 23.5: 9 to 38.
  AddPanel(3.04f, 1.0f, 2);
  Export();
  const nlohmann::json info = Info(0);
  EXPECT_EQ(info["px_count_all"], 92 * 30);
  EXPECT_EQ(info["px_count_visib"], 64 * 30);
  EXPECT_EQ(info["px_count_valid"], 0) << "nothing was measured";
  EXPECT_NEAR(info["visib_fract"].get<double>(), 64.0 / 92.0, 1e-12);
  // bop_toolkit's width is that between the centres of the outermost pixels.
  EXPECT_EQ(info["bbox_obj"], nlohmann::json({-14, 9, 91, 29}));
  EXPECT_EQ(info["bbox_visib"], nlohmann::json({0, 9, 63, 29}));
  EXPECT_EQ(cv::countNonZero(Mask("mask", "000000_000000.png")), 64 * 30);
  EXPECT_EQ(Mask("mask", "000000_000000.png").size(), cv::Size(64, 48));
}

TEST_F(BopFiles, TheCanvasEndsAtThreeTimesTheImage) {
  Open();
  AddPanel(30, 30, 1);  // 1800 pixels wide
  AddPanel(0.2f, 0.2f, -1);
  Export();
  EXPECT_EQ(Info(0)["px_count_all"], 9 * 64 * 48);
  EXPECT_EQ(Info(0)["bbox_obj"], nlohmann::json({-64, -48, 3 * 64 - 1, 3 * 48 - 1}));
  EXPECT_EQ(Info(1)["px_count_all"], 0) << "behind the camera";
  EXPECT_EQ(Info(1)["bbox_obj"], nlohmann::json({-1, -1, -1, -1}));
  EXPECT_EQ(Info(1)["visib_fract"], 0.0);
}

TEST_F(BopFiles, AnObjectAroundTheCameraFillsTheCanvas) {
  Open();
  AddPanel(2, 2, -0.005);  // the camera is inside: sides 1 m away, faces before the near plane
  models_[0].mesh = MakeBox({-1, -1, -1}, {1, 1, 1});
  Export();
  EXPECT_EQ(Info(0)["px_count_all"], 9 * 64 * 48);
}

TEST_F(BopFiles, MeasuredDepthHidesWhatIsMoreThanFifteenMillimetresBehindItAlongTheRay) {
  // Columns of the picture: nothing measured, 20 mm before the panel, 14 mm before it, behind it.
  cv::Mat depth(48, 64, CV_16U, cv::Scalar(0));
  depth.colRange(16, 32) = 980;
  depth.colRange(32, 48) = 986;
  depth.colRange(48, 64) = 1500;
  WriteDepth(depth);
  Open();
  AddPanel(4, 4, 1);
  Export({0, 1});
  const cv::Mat shows = Mask("mask_visib", "000000_000000.png");
  EXPECT_EQ(cv::countNonZero(shows.colRange(0, 16)), 16 * 48) << "no measurement hides nothing";
  EXPECT_EQ(cv::countNonZero(shows.colRange(16, 32)), 0);
  EXPECT_EQ(cv::countNonZero(shows.colRange(48, 64)), 16 * 48);
  // 14 mm in z are more than 15 mm along rays more than acos(14 / 15) off the axis.
  int expected = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 32; x < 48; ++x) {
      const double u = (x - 31.5) / 60, v = (y - 23.5) / 60;
      expected += 14 * std::sqrt(1 + u * u + v * v) <= 15;
    }
  }
  EXPECT_LT(expected, 16 * 48);
  EXPECT_EQ(cv::countNonZero(shows.colRange(32, 48)), expected);
  const nlohmann::json info = Info(0);
  EXPECT_EQ(info["px_count_valid"], 48 * 48);
  EXPECT_EQ(info["px_count_visib"], cv::countNonZero(shows));
  const cv::Mat written = Mask("depth", "000000.png");
  EXPECT_EQ(written.type(), CV_16U);
  EXPECT_EQ(cv::countNonZero(written != depth), 0) << "as it was measured";
  EXPECT_FALSE(std::filesystem::exists(Scene() / "depth" / "000001.png")) << "has none";
}

TEST_F(BopFiles, WithoutDepthTheOtherObjectsHide) {
  Open();
  AddPanel(0.4f, 0.4f, 1.5);
  AddPanel(0.2f, 0.2f, 1);  // 12 pixels wide, before the middle of the first one's 16
  Export();
  EXPECT_EQ(Info(0)["px_count_all"], 16 * 16);
  EXPECT_EQ(Info(0)["px_count_visib"], 16 * 16 - 12 * 12);
  EXPECT_EQ(Info(1)["px_count_visib"], 12 * 12);
}

TEST_F(BopFiles, WhereNothingWasMeasuredTheNearestOfSeveralIsShown) {
  WriteDepth(cv::Mat(48, 64, CV_16U, cv::Scalar(0)));
  Open();
  AddPanel(0.4f, 0.4f, 1.5);
  AddPanel(0.2f, 0.2f, 1);
  Export();
  EXPECT_EQ(Info(0)["px_count_visib"], 16 * 16) << "as BOP has it";
  const auto models = ModelDatabase::FromModels(models_);
  const auto shown = VisibleInstances(document_, {models.get(), sequence_.get(), {}, nullptr}, 0);
  ASSERT_TRUE(shown.ok()) << shown.error().message;
  EXPECT_EQ(cv::countNonZero(*shown == 1), 16 * 16 - 12 * 12);
}

TEST_F(BopFiles, TargetsAreWhatShowsByATenth) {
  Open();
  AddPanel(0.4f, 0.4f, 1.5);
  AddPanel(0.3f, 0.3f, 1);  // hides all of it
  document_.instances.push_back(document_.instances[1]);
  document_.instances[2].scan_from_object.translation().x() += 0.35;
  Export({0, 1});
  const nlohmann::json targets = ReadJson(Bop() / "test_targets_bop19.json").value();
  ASSERT_FALSE(targets.empty());
  EXPECT_EQ(targets[0],
            nlohmann::json({{"scene_id", 0}, {"im_id", 0}, {"obj_id", 2}, {"inst_count", 2}}));
  for (const nlohmann::json& target : targets) EXPECT_NE(target["obj_id"], 1);
}

TEST_F(BopFiles, EveryFrameHasItsCamera) {
  Open();
  AddPanel(0.4f, 0.4f, 1.5);
  Export({0, 1});
  const nlohmann::json cameras = ReadJson(Scene() / "scene_camera.json").value();
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras["0"]["cam_K"], nlohmann::json({60, 0, 31.5, 0, 60, 23.5, 0, 0, 1}));
  // The second camera is 1 m further along x, turned as the first one.
  EXPECT_NEAR(
      cameras["0"]["cam_t_w2c"][0].get<double>() - cameras["1"]["cam_t_w2c"][0].get<double>(), 1000,
      1e-9);
  EXPECT_EQ(cameras["1"]["depth_scale"], 1.0);
}

TEST_F(BopFiles, ModelsKeepTheirColoursAndTheirTexture) {
  std::filesystem::create_directories(folder_.path() / "models");
  ASSERT_TRUE(cv::imwrite((folder_.path() / "models" / "wood grain.png").string(),
                          cv::Mat(4, 4, CV_8UC3, cv::Scalar(10, 90, 200))));
  Open();
  for (int i = 0; i < 2; ++i) AddPanel(0.4f, 0.4f, 1.5 + i);
  TriangleMesh &painted = models_[0].mesh, &papered = models_[1].mesh;
  painted.colors.assign(painted.vertices.size(), {200, 100, 50});
  papered.texture_coordinates.assign(papered.vertices.size(), {0.25f, 0.75f});
  papered.texture_file = "wood grain.png";
  std::string list;
  for (CadModel& model : models_) {
    model.file = model.name + ".ply";
    ASSERT_TRUE(WritePly(folder_.path() / "models" / model.file, model.mesh).ok());
    list += (list.empty() ? "" : ",") +
            nlohmann::json({{"name", model.name}, {"file", model.file}, {"category", "tv"}}).dump();
  }
  WriteText(folder_.path() / "models" / "models.json", "{\"models\": [" + list + "]}");
  const auto models = ModelDatabase::Load(folder_.path() / "models");
  ASSERT_TRUE(models.ok()) << models.error().message;
  document_.instances[1].scale = 1.5;  // has a model of its own, with the same texture
  const UnscaledAnnotations sized = WithScaledModels(document_, models->get());
  ASSERT_NE(sized.models, nullptr);
  const Status written =
      WriteBop(sized.document, {sized.models.get(), sequence_.get(), {0}, nullptr}, Bop(), {});
  ASSERT_TRUE(written.ok()) << written.error().message;
  const auto first = ReadMesh(Bop() / "models" / "obj_000001.ply");
  ASSERT_TRUE(first.ok()) << first.error().message;
  ASSERT_EQ(first->colors.size(), 8u);
  EXPECT_EQ(first->colors[3], (std::array<std::uint8_t, 3>{200, 100, 50}));
  EXPECT_NEAR(BoundingBox(*first).sizes().x(), 400, 0.01);
  const auto second = ReadMesh(Bop() / "models" / "obj_000003.ply");
  ASSERT_TRUE(second.ok()) << second.error().message;
  EXPECT_NEAR(BoundingBox(*second).sizes().x(), 600, 0.01);
  // bop_toolkit takes the last word of the line as the file, and texture_u, texture_v.
  EXPECT_EQ(second->texture_file, "obj_000003.png");
  ASSERT_EQ(second->texture_coordinates.size(), 8u);
  EXPECT_FLOAT_EQ(second->texture_coordinates[5].y(), 0.75f);
  EXPECT_EQ(*ReadFile(Bop() / "models" / "obj_000003.png"),
            *ReadFile(folder_.path() / "models" / "wood grain.png"));
  const auto text = ReadFile(Bop() / "models" / "obj_000003.ply");
  EXPECT_NE(text->find("property float texture_u"), std::string::npos);
}

}  // namespace
}  // namespace plumbline
