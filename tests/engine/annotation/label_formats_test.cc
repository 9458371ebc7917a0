// SPDX-License-Identifier: Apache-2.0
// COCO, Scan2CAD, LabelFusion and glTF, by what their readers look for.

#include <yaml-cpp/yaml.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/annotation/annotation_export.h"
#include "engine/annotation/coco_files.h"
#include "engine/annotation/instance_masks.h"
#include "engine/annotation/scan2cad_files.h"
#include "engine/base/files.h"
#include "engine/models/mesh_file.h"
#include "tests/support/furniture_models.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

/// A tilted scan in which a chair and a scaled table stand before the first camera.
class LabelFormats : public testing::Test {
 protected:
  void SetUp() override {
    WriteTinySequence(folder_.path() / "walk", {.frames = 3});
    auto sequence = OpenSequence(folder_.path() / "walk");
    ASSERT_TRUE(sequence.ok()) << sequence.error().message;
    sequence_ = *sequence;
    document_.gravity_in_scan = Eigen::Vector3d(0.1, 0.2, -1).normalized();
    document_.floor_in_scan = (Eigen::Vector4d() << -document_.gravity_in_scan, -0.3).finished();
    Add("the red chair", "chair", "chair", {0, 0, 2.5}, 1);
    Add("table: 1", "table", "dining table", {0.3, 0.2, 4}, 1.25);
  }
  void Add(const char* id, const char* model, const char* category, const Eigen::Vector3d& in_cam,
           double scale) {
    AnnotatedInstance instance;
    instance.id = id;
    instance.model = model;
    instance.category = category;
    const Eigen::Isometry3d level_from_scan = document_.LevelFromScan();
    instance.scan_from_object = level_from_scan.inverse();  // upright
    instance.scan_from_object.translation() = *ScanFromCam(document_, *sequence_, 0) * in_cam;
    instance.scale = scale;
    document_.instances.push_back(instance);
  }
  ExchangeInputs Inputs() const { return {models_.get(), sequence_.get(), {0, 1, 2}, nullptr}; }
  std::filesystem::path Export(const char* format, const char* name,
                               PoseFrame frame = PoseFrame::kScan) {
    ExportRequest request{format, folder_.path() / name, frame};
    const Status written = ExportAnnotation(document_, Inputs(), "", request, {});
    EXPECT_TRUE(written.ok()) << written.error().message;
    return request.out;
  }

  TemporaryFolder folder_;
  std::shared_ptr<const ModelDatabase> models_ = MakeFurnitureDatabase();
  std::shared_ptr<const Sequence> sequence_;
  AnnotationDocument document_;
};

TEST_F(LabelFormats, RunsGoDownTheColumnsFromTheFirstPixel) {
  cv::Mat mask(3, 4, CV_8U, cv::Scalar(0));
  mask.at<std::uint8_t>(1, 0) = 255;
  mask.at<std::uint8_t>(2, 0) = 255;
  mask.at<std::uint8_t>(0, 1) = 255;
  EXPECT_EQ(ColumnRuns(mask), (std::vector<int>{1, 3, 8}));
  mask.setTo(255);
  EXPECT_EQ(ColumnRuns(mask), (std::vector<int>{0, 12})) << "it begins with unset ones";
  mask.setTo(0);
  EXPECT_EQ(ColumnRuns(mask), (std::vector<int>{12}));
}

TEST_F(LabelFormats, CocosMasksAreThoseOfTheImagesOfInstances) {
  const std::filesystem::path out = Export("coco", "coco");
  const nlohmann::json coco = ReadJson(out / "instances.json").value();
  ASSERT_EQ(coco["images"].size(), 3u);
  EXPECT_EQ(coco["categories"],
            nlohmann::json({{{"id", 62}, {"name", "chair"}, {"supercategory", "object"}},
                            {{"id", 67}, {"name", "dining table"}, {"supercategory", "object"}}}));
  ASSERT_GE(coco["annotations"].size(), 2u);
  for (const nlohmann::json& annotation : coco["annotations"]) {
    const nlohmann::json& image = coco["images"][annotation["image_id"].get<std::size_t>() - 1];
    const std::string name = std::filesystem::path(image["file_name"]).filename();
    EXPECT_TRUE(std::filesystem::exists(out / "images" / name));
    const cv::Mat numbers = cv::imread((out / "masks" / name).string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(numbers.type(), CV_16U);
    const cv::Mat shows = numbers == annotation["instance_number"].get<int>();
    EXPECT_EQ(annotation["area"], cv::countNonZero(shows));
    const cv::Rect box = cv::boundingRect(shows);
    EXPECT_EQ(annotation["bbox"], nlohmann::json({box.x, box.y, box.width, box.height}));
    // Decoded as COCO's tools do.
    cv::Mat decoded(48, 64, CV_8U, cv::Scalar(0));
    int at = 0, value = 0;
    for (const int run : annotation["segmentation"]["counts"]) {
      for (int i = 0; i < run; ++i, ++at) decoded.at<std::uint8_t>(at % 48, at / 48) = value;
      value = 255 - value;
    }
    EXPECT_EQ(at, 48 * 64);
    EXPECT_EQ(cv::countNonZero(decoded != shows), 0);
    EXPECT_EQ(annotation["iscrowd"], 0);
  }
}

TEST_F(LabelFormats, CategoriesThatCocoLacksHaveNumbersBeyondItsOwn) {
  document_.instances[0].category = "cabinet";
  const nlohmann::json coco = ReadJson(Export("coco", "coco") / "instances.json").value();
  EXPECT_EQ(coco["categories"][0]["id"], 1000);
  EXPECT_EQ(coco["categories"][0]["name"], "cabinet");
}

/// As Scan2CAD's scripts make it: translation * rotation * scale.
Eigen::Affine3d FromTrs(const nlohmann::json& trs) {
  const auto& t = trs["translation"];
  const auto& q = trs["rotation"];
  const auto& s = trs["scale"];
  return Eigen::Translation3d(t[0], t[1], t[2]) * Eigen::Quaterniond(q[0], q[1], q[2], q[3]) *
         Eigen::Scaling(s[0].get<double>(), s[1].get<double>(), s[2].get<double>());
}

TEST_F(LabelFormats, Scan2CadsModelsStandInTheScanThatIsMovedByItsTrs) {
  const TriangleMesh scan = MakeBox({0, 0, 0}, {1, 1, 1});
  ASSERT_TRUE(WritePly(folder_.path() / "hall 1.ply", scan).ok());
  const ExportRequest request{"scan2cad", folder_.path() / "scan2cad", PoseFrame::kScan};
  const Status written =
      ExportAnnotation(document_, Inputs(), folder_.path() / "hall 1.ply", request, {});
  ASSERT_TRUE(written.ok()) << written.error().message;
  const nlohmann::json all = ReadJson(request.out / "full_annotations.json").value();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0]["id_scan"], "hall_1");
  EXPECT_EQ(all[0]["n_aligned_models"], 2);
  EXPECT_TRUE(exists(request.out / "scannet/hall_1/hall_1_vh_clean_2.ply"));
  const Eigen::Affine3d world_from_scan = FromTrs(all[0]["trs"]);
  // y is up and the floor at 0: of the scan's up axis, and of a point on its floor.
  EXPECT_LT(
      (world_from_scan.linear() * -document_.gravity_in_scan - Eigen::Vector3d::UnitY()).norm(),
      1e-9);
  const Eigen::Vector3d on_floor = -document_.gravity_in_scan * 0.3;
  EXPECT_NEAR((world_from_scan * on_floor).y(), 0, 1e-9);
  for (int i = 0; i < 2; ++i) {
    const nlohmann::json& aligned = all[0]["aligned_models"][i];
    const AnnotatedInstance& instance = document_.instances[static_cast<std::size_t>(i)];
    const auto mesh = ReadMesh(request.out / "shapenet" / aligned["catid_cad"] / aligned["id_cad"] /
                               "models" / "model_normalized.obj");
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    const TriangleMesh& ours = models_->model(*models_->Find(instance.model)).mesh;
    // The box around the model as the file places it, and around ours, in the scan.
    Eigen::AlignedBox3d there, here, unit;
    for (const Eigen::Vector3f& v : mesh->vertices)
      there.extend(world_from_scan.inverse() * FromTrs(aligned["trs"]) * v.cast<double>());
    for (const Eigen::Vector3f& v : ours.vertices)
      here.extend(instance.scan_from_object * (instance.scale * v.cast<double>()));
    EXPECT_LT((there.min() - here.min()).norm() + (there.max() - here.max()).norm(), 1e-5);
    // Its own box: center +- bbox, in the model's frame.
    const Eigen::AlignedBox3f own = BoundingBox(*mesh);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(aligned["center"][k].get<double>(), own.center()[k], 1e-6);
      EXPECT_NEAR(aligned["bbox"][k].get<double>(), own.sizes()[k] / 2, 1e-6);
    }
  }
  EXPECT_EQ(all[0]["aligned_models"][0]["sym"], "__SYM_NONE");
  EXPECT_EQ(all[0]["aligned_models"][1]["sym"], "__SYM_ROTATE_UP_2");
  EXPECT_EQ(ReadJson(request.out / "cad_appearances.json").value()["hall_1"]["chair_chair"], 1);
}

TEST_F(LabelFormats, LabelFusionsRendererFindsEachObjectByItsLabel) {
  Add("the red chair", "chair", "chair", {0.5, 0, 3}, 1);  // the same name once more
  const std::filesystem::path out = Export("labelfusion", "labelfusion");
  const YAML::Node result = YAML::LoadFile(out / "registration_result.yaml"),
                   objects = YAML::LoadFile(out / "object_data.yaml");
  ASSERT_EQ(result.size(), 3u);
  ASSERT_EQ(objects.size(), 3u);
  std::set<int> labels;
  for (const auto& entry : result) {
    const auto name = entry.first.as<std::string>();
    EXPECT_TRUE(std::all_of(name.begin(), name.end(),
                            [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; }))
        << name << ": it writes names into YAML as they are";
    const YAML::Node object = objects[name];
    ASSERT_TRUE(object) << name;
    labels.insert(object["label"].as<int>());
    EXPECT_EQ(object["mesh"].as<std::string>(), entry.second["filename"].as<std::string>());
    EXPECT_TRUE(exists(out / object["mesh"].as<std::string>()));
  }
  EXPECT_EQ(labels, (std::set<int>{1, 2, 3})) << "0 is the background";
  // A scaled object has a mesh of its size.
  const auto table = ReadMesh(out / "object-meshes" / "table_x1_2500.ply");
  ASSERT_TRUE(table.ok()) << table.error().message;
  EXPECT_NEAR(BoundingBox(*table).sizes().x(), 1.25 * 1.3, 1e-5);
  // The first camera is its world: camera i is i metres along x from there.
  const std::string cameras = ReadFile(out / "posegraph.posegraph").value();
  EXPECT_EQ(cameras.substr(0, cameras.find('\n')), "0.000000000 0 0 0 0 0 0 1");
  EXPECT_NE(cameras.find("0.200000000 2 0 0 "), std::string::npos) << cameras;
  const auto again = ReadLabelFusion(document_, Inputs(), out);
  ASSERT_TRUE(again.ok()) << again.error().message;
  std::set<std::string> ids;
  for (const AnnotatedInstance& instance : again->instances) ids.insert(instance.id);
  EXPECT_TRUE(ids.contains("table: 1"));
  ExportRequest file{"labelfusion", folder_.path() / "registration_result.yaml"};
  EXPECT_THAT(ExportAnnotation(document_, Inputs(), "", file, {}).error().message,
              testing::HasSubstr("is a folder"));
}

TEST_F(LabelFormats, GltfIsUprightWhereverUpIsInTheScan) {
  for (const PoseFrame frame : {PoseFrame::kScan, PoseFrame::kLevel}) {
    const auto mesh = ReadMesh(Export("gltf", "room.glb", frame));
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    Eigen::AlignedBox3d expected;
    Eigen::Isometry3d room_from_scan = document_.LevelFromScan();
    if (frame == PoseFrame::kScan) room_from_scan.translation().setZero();
    for (const AnnotatedInstance& instance : document_.instances) {
      for (const Eigen::Vector3f& v : models_->model(*models_->Find(instance.model)).mesh.vertices)
        expected.extend(room_from_scan * instance.scan_from_object *
                        (instance.scale * v.cast<double>()));
    }
    const Eigen::AlignedBox3f box = BoundingBox(*mesh);  // y up: z is y, y is -z
    EXPECT_NEAR(box.min().y(), expected.min().z(), 1e-5);
    EXPECT_NEAR(box.max().y(), expected.max().z(), 1e-5);
    EXPECT_NEAR(box.min().x(), expected.min().x(), 1e-5);
    EXPECT_NEAR(box.min().z(), -expected.max().y(), 1e-5);
  }
}

}  // namespace
}  // namespace plumbline
