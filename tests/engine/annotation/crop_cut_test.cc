// SPDX-License-Identifier: Apache-2.0
// Objects that are cut out of a scan.

#include "engine/annotation/crop_cut.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/annotation/annotation_check.h"
#include "engine/geometry/gravity.h"
#include "engine/geometry/surface_sampling.h"
#include "engine/models/mesh_file.h"
#include "tests/engine/annotation/random_edits.h"
#include "tests/support/furniture_models.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

/// A cabinet of 0.6 x 0.4 x 0.8 m that stands on a floor at (1, 2), turned by 30 degrees, a crumb
/// beside it and a stool; in a scan whose up is no axis.
class CutCabinet : public testing::Test {
 protected:
  static constexpr double kAzimuth = 0.5236;

  void SetUp() override {
    scan_from_level_.linear() = UprightFrame(-up_).upright_rotation();
    scan_from_level_.translation() = Eigen::Vector3d(0.3, -0.2, 0.5);
    level_from_cabinet_.linear() =
        Eigen::AngleAxisd(kAzimuth, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    level_from_cabinet_.translation() = Eigen::Vector3d(1, 2, 0);
    TriangleMesh level = MakeGrid({-1, -1, 0}, {5, 0, 0}, {0, 5, 0}, 200);
    Append(Transformed(MakeFineBox({0.6f, 0.4f, 0.8f}), level_from_cabinet_), level);
    Append(MakeGrid({1.4f, 2.2f, 0.5f}, {0.01f, 0, 0}, {0, 0.01f, 0}, 1), level);
    Append(Transformed(MakeFineBox({0.3f, 0.3f, 0.4f}),
                       Eigen::Isometry3d(Eigen::Translation3d(2.2, 2, 0))),
           level);
    scan_ = Transformed(level, scan_from_level_);
    document_.gravity_in_scan = -up_;
    document_.models = "models";
  }

  Crop BoxCrop(const std::string& id) const {
    Crop crop;
    crop.id = id;
    crop.category = "refrigerator";
    crop.region =
        CropBox{scan_from_level_ * Eigen::Vector3d(1, 2, 0.45), {1.0, 0.8, 1.0}, kAzimuth};
    return crop;
  }

  /// A line around the cabinet as seen from in front of it, 3 m away; the stool is behind, in part.
  Crop LassoCrop(const std::string& id) const {
    CropLasso lasso;
    const Eigen::Vector3d eye(1 + 3 * std::cos(kAzimuth), 2 + 3 * std::sin(kAzimuth), 1.2);
    const Eigen::Vector3d forward = (Eigen::Vector3d(1, 2, 0.4) - eye).normalized();
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Isometry3d level_from_cam = Eigen::Isometry3d::Identity();
    level_from_cam.linear() << right, forward.cross(right), forward;
    level_from_cam.translation() = eye;
    lasso.scan_from_cam = scan_from_level_ * level_from_cam;
    lasso.camera = {640, 480, 500, 500, 319.5, 239.5};
    for (const Eigen::Vector3d& corner :
         {Eigen::Vector3d(0.4, -0.26, -0.05), Eigen::Vector3d(0.4, 0.26, -0.05),
          Eigen::Vector3d(0.4, 0.26, 0.95), Eigen::Vector3d(0.4, -0.26, 0.95)}) {
      lasso.polygon_px.push_back(
          lasso.camera.Project(level_from_cam.inverse() * (level_from_cabinet_ * corner)));
    }
    lasso.near_m = 2;
    lasso.far_m = 3.5;
    Crop crop;
    crop.id = id;
    crop.category = "refrigerator";
    crop.region = std::move(lasso);
    return crop;
  }

  Result<PreparedCrop> Prepare(const Crop& crop) const {
    return PrepareCrop(scan_, "scan.ply", crop, document_, folder_.path() / "models");
  }

  const Eigen::Vector3d up_ = Eigen::Vector3d(0.2, -0.3, 0.9).normalized();
  Eigen::Isometry3d scan_from_level_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d level_from_cabinet_ = Eigen::Isometry3d::Identity();
  TriangleMesh scan_;
  AnnotationDocument document_;
  TemporaryFolder folder_;
};

TEST_F(CutCabinet, ABoxMakesAModelInTheCanonicalFrameAndAnInstanceWhereItStands) {
  const auto prepared = Prepare(BoxCrop("cabinet"));
  ASSERT_TRUE(prepared.ok()) << prepared.error().message;
  const CadModel& model = prepared->model->built.model;
  EXPECT_EQ(prepared->model->pieces_dropped, 1);
  EXPECT_EQ(model.name, "cabinet");
  // Front along x: 0.6 deep, 0.4 wide; the strip that went with the floor is a grid's row.
  EXPECT_NEAR(model.bounds.sizes().x(), 0.6, 1e-3);
  EXPECT_NEAR(model.bounds.sizes().y(), 0.4, 1e-3);
  EXPECT_NEAR(model.bounds.max().z(), 0.8, 1e-3);
  EXPECT_GT(model.bounds.min().z(), 0.01);
  EXPECT_LT(model.bounds.min().z(), 0.05);
  ASSERT_TRUE(ApplyEdit(prepared->edit, document_).ok());
  ASSERT_EQ(document_.instances.size(), 1u);
  EXPECT_EQ(document_.instances[0].id, "cabinet_0");
  EXPECT_EQ(document_.instances[0].model, "cabinet");
  EXPECT_THAT(document_.instances[0].scan_from_object,
              IsometryNear(scan_from_level_ * level_from_cabinet_, 1e-3, 1e-3));
  EXPECT_LT(UprightFrame(-up_).Tilt(document_.instances[0].scan_from_object.linear()), 1e-9);
  ASSERT_TRUE(document_.crops[0].support_in_scan.has_value());
}

TEST_F(CutCabinet, TheDatabaseReadsTheModelAndKeepsItsName) {
  const auto prepared = Prepare(BoxCrop("cabinet"));
  ASSERT_TRUE(prepared.ok());
  ASSERT_TRUE(StoreModel(prepared->model->built, folder_.path() / "models").ok());
  const auto models = ModelDatabase::Load(folder_.path() / "models");
  ASSERT_TRUE(models.ok()) << models.error().message;
  ASSERT_TRUE((*models)->Find("cabinet").has_value());
  // No model is replaced by a crop.
  const auto again = Prepare(BoxCrop("cabinet"));
  ASSERT_FALSE(again.ok());
  EXPECT_THAT(again.error().message, testing::HasSubstr("already"));
}

TEST_F(CutCabinet, ALassoTakesWhatIsInItsDepthAndFindsTheFront) {
  const auto prepared = Prepare(LassoCrop("cabinet"));
  ASSERT_TRUE(prepared.ok()) << prepared.error().message;
  ASSERT_TRUE(ApplyEdit(prepared->edit, document_).ok());
  const auto& model = prepared->model->built.model;
  EXPECT_NEAR(model.bounds.sizes().x(), 0.6, 0.01);
  EXPECT_NEAR(model.bounds.sizes().y(), 0.4, 0.01);
  EXPECT_THAT(document_.instances[0].scan_from_object,
              IsometryNear(scan_from_level_ * level_from_cabinet_, 0.6, 0.01));
  // Without a far end it also holds what is behind.
  Crop deep = LassoCrop("deep");
  std::get<CropLasso>(deep.region).far_m = 100;
  EXPECT_GT(PointsInRegion(scan_, *CompletedCrop(deep, scan_, document_)).size(),
            PointsInRegion(scan_, document_.crops[0]).size());
}

TEST_F(CutCabinet, TheSupportCanStayAndMayBeAPlaneOrTheFloor) {
  Crop kept = BoxCrop("kept");
  kept.without_support = false;
  Crop given = BoxCrop("given");
  given.support_in_scan = (Eigen::Vector4d() << up_, -up_.dot(scan_from_level_.translation()) - 0.4)
                              .finished();  // as if it stood on something 0.4 m high
  const auto with = CutOut(scan_, *CompletedCrop(kept, scan_, document_));
  const auto without = CutOut(scan_, *CompletedCrop(BoxCrop("x"), scan_, document_));
  const auto half = CutOut(scan_, *CompletedCrop(given, scan_, document_));
  ASSERT_TRUE(with.ok() && without.ok() && half.ok());
  EXPECT_GT(with->vertices.size(), without->vertices.size() + 200);
  EXPECT_LT(half->vertices.size(), without->vertices.size() * 3 / 4);
  // A region that shows no level surface falls back on the floor, and says when there is none.
  Crop high = BoxCrop("high");
  std::get<CropBox>(high.region).center_in_scan += 0.3 * up_;
  std::get<CropBox>(high.region).size_m = {0.7, 0.5, 0.5};
  EXPECT_FALSE(CompletedCrop(high, scan_, document_).ok());
  document_.floor_in_scan =
      (Eigen::Vector4d() << up_, -up_.dot(scan_from_level_.translation())).finished();
  const auto on_floor = CompletedCrop(high, scan_, document_);
  ASSERT_TRUE(on_floor.ok());
  EXPECT_EQ(*on_floor->support_in_scan, *document_.floor_in_scan);
}

TEST_F(CutCabinet, IsUndoneAndRedoneExactly) {
  const std::string before = DocumentToJson(document_).dump();
  const auto prepared = Prepare(LassoCrop("cabinet"));
  ASSERT_TRUE(prepared.ok());
  const auto undo = ApplyEdit(prepared->edit, document_);
  ASSERT_TRUE(undo.ok());
  const std::string after = DocumentToJson(document_).dump();
  const auto redo = ApplyEdit(*undo, document_);
  ASSERT_TRUE(redo.ok());
  EXPECT_EQ(DocumentToJson(document_).dump(), before);
  ASSERT_TRUE(ApplyEdit(*redo, document_).ok());
  EXPECT_EQ(DocumentToJson(document_).dump(), after);
  EXPECT_EQ(DescribeEdit(prepared->edit), "Cut out cabinet");
}

TEST_F(CutCabinet, RefusesWhatIsNoCrop) {
  Crop nowhere = BoxCrop("nowhere");
  std::get<CropBox>(nowhere.region).center_in_scan += 9 * up_;
  nowhere.without_support = false;
  EXPECT_EQ(Prepare(nowhere).error().code, ErrorCode::kDegenerate);
  Crop flat = BoxCrop("flat");
  std::get<CropBox>(flat.region).size_m.z() = 0;
  EXPECT_EQ(Prepare(flat).error().code, ErrorCode::kInvalidInput);
  Crop nameless = BoxCrop("../up");
  EXPECT_EQ(Prepare(nameless).error().code, ErrorCode::kInvalidInput);
  Crop fragment = BoxCrop("cabinet");
  fragment.into = Crop::Into::kFragment;
  EXPECT_THAT(Prepare(fragment).error().message, testing::HasSubstr("<model>_<number>"));
  Crop line = LassoCrop("line");
  std::get<CropLasso>(line.region).polygon_px.resize(2);
  EXPECT_EQ(Prepare(line).error().code, ErrorCode::kInvalidInput);
  scan_.triangles.clear();
  EXPECT_THAT(Prepare(BoxCrop("points")).error().message, testing::HasSubstr("needs a surface"));
}

TEST_F(CutCabinet, AFragmentIsWrittenWithVismasFolder) {
  Crop crop = BoxCrop("cabinet_3");
  crop.into = Crop::Into::kFragment;
  scan_.triangles.clear();
  const auto prepared = Prepare(crop);
  ASSERT_TRUE(prepared.ok()) << prepared.error().message;
  EXPECT_FALSE(prepared->model.has_value());
  ASSERT_TRUE(ApplyEdit(prepared->edit, document_).ok());
  const auto models = MakeFurnitureDatabase();
  ASSERT_TRUE(WriteVisma(document_, models.get(), folder_.path()).ok());
  ASSERT_TRUE(WriteVismaScene(document_, *models, scan_, 0.03, folder_.path()).ok());
  const auto fragment = ReadMesh(folder_.path() / "fragments" / "cabinet_3.ply");
  ASSERT_TRUE(fragment.ok()) << fragment.error().message;
  EXPECT_EQ(fragment->vertices.size(), CutOut(scan_, document_.crops[0])->vertices.size());
  const auto read = ReadVisma(folder_.path());
  ASSERT_TRUE(read.ok());
  ASSERT_EQ(read->warnings.size(), 1u);
  EXPECT_THAT(read->warnings[0], testing::HasSubstr("no pose of 'cabinet_3'"));
}

TEST_F(CutCabinet, TheCheckKnowsCrops) {
  const auto models = MakeFurnitureDatabase();
  document_.crops.push_back(CompletedCrop(BoxCrop("cabinet"), scan_, document_).value());
  Crop nowhere = BoxCrop("stool_0");
  nowhere.into = Crop::Into::kFragment;
  std::get<CropBox>(nowhere.region).center_in_scan += 9 * up_;
  nowhere.up_in_scan = up_;
  nowhere.without_support = false;
  document_.crops.push_back(nowhere);
  const auto findings = CheckAnnotations(document_, {models.get(), nullptr, {}, &scan_});
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].kind, "unmade_crop");
  EXPECT_EQ(findings[0].instances, std::vector<std::string>{"cabinet"});
  EXPECT_EQ(findings[1].kind, "empty_crop");
  EXPECT_EQ(findings[1].instances, std::vector<std::string>{"stool_0"});
}

TEST(Crop, MistakesInJsonAreSentences) {
  const auto message = [](const char* text) {
    const auto crop = CropFromJson(nlohmann::json::parse(text));
    return crop.ok() ? std::string("no error") : crop.error().message;
  };
  EXPECT_THAT(message(R"({"id": "a"})"), testing::HasSubstr("either a 'box' or a 'lasso'"));
  EXPECT_THAT(message(R"({"id": "a", "box": {"center": [0, 0, 0]}})"),
              testing::HasSubstr("'center' and 'size'"));
  EXPECT_THAT(message(R"({"id": "a", "lasso": {"polygon": []}})"),
              testing::HasSubstr("'scan_from_cam'"));
  EXPECT_THAT(message(R"({"id": "a", "into": "air", "box": {}})"), testing::HasSubstr("'air'"));
  EXPECT_THAT(message(R"({"id": "a", "box": {"center": [0, 0, 0], "size": [1, 1, 1]},
                         "support": "table"})"),
              testing::HasSubstr("four numbers"));
}

}  // namespace
}  // namespace plumbline
