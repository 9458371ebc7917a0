// SPDX-License-Identifier: Apache-2.0
// Every format both ways, to 1e-9.

#include "engine/annotation/pose_exchange.h"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/annotation/annotation_check.h"
#include "engine/annotation/annotation_export.h"
#include "engine/annotation/bop_files.h"
#include "engine/annotation/instance_masks.h"
#include "engine/annotation/scaled_models.h"
#include "engine/base/files.h"
#include "engine/dataset/visma_sequence.h"
#include "engine/geometry/gravity.h"
#include "engine/models/mesh_file.h"
#include "tests/engine/annotation/random_edits.h"
#include "tests/support/furniture_models.h"
#include "tests/support/random_pose.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

class PoseExchange : public testing::Test {
 protected:
  void SetUp() override {
    WriteTinySequence(folder_.path() / "walk");
    auto sequence = OpenSequence(folder_.path() / "walk");
    ASSERT_TRUE(sequence.ok()) << sequence.error().message;
    sequence_ = *sequence;
    Random random({.seed = 9});
    document_.gravity_in_scan = Eigen::Vector3d(0.1, -0.2, -1).normalized();
    document_.scan_from_world = RandomPose(random);
    for (int i = 0; i < 6; ++i) {
      const CadModel& model = models_->models()[static_cast<std::size_t>(i) % 4];
      AnnotatedInstance instance = RandomInstance(model.name + "_" + std::to_string(i), random);
      instance.model = model.name;
      instance.category = model.category;
      document_.instances.push_back(instance);
    }
  }

  /// By id, or by model and place where the format has no ids.
  void ExpectSame(const ImportedPoses& imported, bool ids = true) const {
    EXPECT_TRUE(imported.warnings.empty()) << imported.warnings[0];
    ASSERT_EQ(imported.instances.size(), document_.instances.size());
    for (const AnnotatedInstance& wanted : document_.instances) {
      const AnnotatedInstance* found = nullptr;
      for (const AnnotatedInstance& instance : imported.instances) {
        if (ids ? instance.id == wanted.id
                : instance.model == wanted.model && (instance.scan_from_object.translation() -
                                                     wanted.scan_from_object.translation())
                                                            .norm() < 1e-6) {
          found = &instance;
        }
      }
      ASSERT_NE(found, nullptr) << wanted.id;
      EXPECT_EQ(found->model, wanted.model);
      EXPECT_LT((found->scan_from_object.matrix() - wanted.scan_from_object.matrix())
                    .cwiseAbs()
                    .maxCoeff(),
                1e-9);
    }
  }

  ExchangeInputs Inputs() const { return {models_.get(), sequence_.get(), {0, 2, 4}}; }

  TemporaryFolder folder_;
  std::shared_ptr<const ModelDatabase> models_ = MakeFurnitureDatabase();
  std::shared_ptr<const Sequence> sequence_;
  AnnotationDocument document_;
};

TEST_F(PoseExchange, GroundTruthComesBack) {
  const auto file = folder_.path() / "ground_truth.json";
  ASSERT_TRUE(WriteGroundTruthOf(document_, PoseFrame::kScan, file).ok());
  const auto read = ReadGroundTruthPoses(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ExpectSame(*read);
  EXPECT_LT((*read->gravity_in_scan - document_.gravity_in_scan).norm(), 1e-12);
}

TEST_F(PoseExchange, GroundTruthIsWrittenInTheFrameAskedFor) {
  document_.floor_in_scan = (Eigen::Vector4d() << -document_.gravity_in_scan, -0.3).finished();
  const auto file = folder_.path() / "ground_truth.json";
  ASSERT_TRUE(WriteGroundTruthOf(document_, PoseFrame::kLevel, file).ok());
  const auto level = ReadGroundTruthPoses(file);
  ASSERT_TRUE(level.ok());
  EXPECT_LT((*level->gravity_in_scan - Eigen::Vector3d(0, 0, -1)).norm(), 1e-9);
  const Eigen::Vector3d at = document_.instances[0].scan_from_object.translation();
  EXPECT_NEAR(level->instances[0].scan_from_object.translation().z(),
              -document_.gravity_in_scan.dot(at) - 0.3, 1e-9);
  ASSERT_TRUE(WriteGroundTruthOf(document_, PoseFrame::kWorld, file).ok());
  const auto world = ReadGroundTruthPoses(file);
  ASSERT_TRUE(world.ok());
  EXPECT_THAT(*document_.scan_from_world * world->instances[0].scan_from_object,
              IsometryNear(document_.instances[0].scan_from_object, 1e-6, 1e-9));
}

TEST_F(PoseExchange, VismaComesBack) {
  const std::filesystem::path out = folder_.path() / "room";
  ASSERT_TRUE(WriteVisma(document_, models_.get(), out).ok());
  for (const auto& folder : {out, out / "fragments"}) {
    const auto read = ReadVisma(folder);
    ASSERT_TRUE(read.ok()) << read.error().message;
    ExpectSame(*read);
    ASSERT_TRUE(read->scan_from_world.has_value());
    EXPECT_LT((read->scan_from_world->matrix() - document_.scan_from_world->matrix()).norm(), 1e-9);
  }
  EXPECT_TRUE(std::filesystem::exists(out / "CAD" / "chair.obj"));
}

TEST_F(PoseExchange, VismaIsTheSameToTheReaderOfSequences) {
  ASSERT_TRUE(WriteVisma(document_, nullptr, folder_.path()).ok());
  std::vector<std::string> warnings;
  const auto truth = ReadVismaTruth(folder_.path() / "fragments", {}, warnings);
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  EXPECT_TRUE(warnings.empty());
  ASSERT_EQ(truth->instances.size(), document_.instances.size());
  for (const GroundTruthInstance& instance : truth->instances) {
    const auto wanted =
        std::find_if(document_.instances.begin(), document_.instances.end(),
                     [&](const AnnotatedInstance& other) { return other.id == instance.id; });
    ASSERT_NE(wanted, document_.instances.end()) << instance.id;
    EXPECT_EQ(instance.model, wanted->model);
    EXPECT_THAT(instance.world_from_object, IsometryNear(wanted->scan_from_object, 1e-6, 1e-9));
  }
}

TEST_F(PoseExchange, VismaIsToldThatScanAndSequenceShareAFrame) {
  document_.scan_from_world.reset();
  ASSERT_TRUE(WriteVisma(document_, models_.get(), folder_.path()).ok());
  // Its own programs stop where this file is missing.
  const nlohmann::json result = ReadJson(folder_.path() / "result_alignment.json").value();
  EXPECT_EQ(result["T_ef_corvis"], nlohmann::json({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}));
  const auto read = ReadVisma(folder_.path());
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_FALSE(read->scan_from_world.has_value());
}

TEST_F(PoseExchange, VismaPosesAreThoseOfModelsWithYUp) {
  AnnotatedInstance upright = document_.instances[0];
  upright.scan_from_object = Eigen::Isometry3d::Identity();
  document_.instances = {upright};
  ASSERT_TRUE(WriteVisma(document_, nullptr, folder_.path()).ok());
  const nlohmann::json alignment =
      ReadJson(folder_.path() / "fragments" / "alignment.json").value();
  const nlohmann::json numbers = alignment.begin().value();
  // Column y of the rotation, the model's up, is the scan's z.
  EXPECT_EQ(numbers[1], 0.0);
  EXPECT_EQ(numbers[5], 0.0);
  EXPECT_EQ(numbers[9], 1.0);
}

TEST_F(PoseExchange, VismasFragmentsAreTheScanNearTheModels) {
  document_.instances.resize(1);
  document_.floor_in_scan = Eigen::Vector4d(0, 0, 1, -8.99);
  const AnnotatedInstance& chair = document_.instances[0];
  TriangleMesh scan =
      Transformed(models_->model(*models_->Find("chair")).mesh, chair.scan_from_object);
  const std::size_t own = scan.vertices.size();
  scan.vertices.emplace_back(9.0f, 9.0f, 9.0f);
  scan.colors.assign(own + 1, {30, 60, 90});
  ASSERT_TRUE(WriteVismaScene(document_, *models_, scan, 0.03, folder_.path()).ok());
  const auto fragment = ReadMesh(folder_.path() / "fragments" / (chair.id + ".ply"));
  ASSERT_TRUE(fragment.ok()) << fragment.error().message;
  EXPECT_EQ(fragment->vertices.size(), own);
  const auto floor = ReadMesh(folder_.path() / "fragments" / "floor.ply");
  ASSERT_TRUE(floor.ok()) << floor.error().message;
  ASSERT_GE(floor->vertices.size(), 1u);
  EXPECT_NEAR(floor->vertices.back().z(), 9, 1e-6);
  EXPECT_EQ(ReadMesh(folder_.path() / "test.klg.ply")->vertices.size(), own + 1);
  // The scan's points in their colours, then samples of the model, in VISMA's green as it has none.
  const auto scene = ReadMesh(folder_.path() / "fragments" / "augmented_scene.ply");
  ASSERT_TRUE(scene.ok());
  ASSERT_GT(scene->vertices.size(), own + 1 + 1000);
  ASSERT_EQ(scene->colors.size(), scene->vertices.size());
  EXPECT_EQ(scene->colors[own], (std::array<std::uint8_t, 3>{30, 60, 90}));
  EXPECT_EQ(scene->colors.back(), (std::array<std::uint8_t, 3>{0, 255, 0}));
  const Eigen::Vector3d sample =
      chair.scan_from_object.inverse() * scene->vertices.back().cast<double>();
  // Single precision, some metres from the origin.
  EXPECT_LT(models_->model(*models_->Find("chair")).bounds.cast<double>().exteriorDistance(sample),
            1e-5);
}

TEST_F(PoseExchange, VismaNamesBeginWithTheModel) {
  document_.instances[0].id = "the red one";
  document_.instances[1].id = "chair_0";  // an armchair
  ASSERT_TRUE(WriteVisma(document_, nullptr, folder_.path()).ok());
  const auto read = ReadVisma(folder_.path());
  ASSERT_TRUE(read.ok());
  ExpectSame(*read, false);
}

TEST_F(PoseExchange, LabelFusionComesBack) {
  const auto out = folder_.path() / "labelfusion";
  ASSERT_TRUE(WriteLabelFusion(document_, Inputs(), out).ok());
  for (const auto& given : {out, out / "registration_result.yaml"}) {
    const auto read = ReadLabelFusion(document_, Inputs(), given);
    ASSERT_TRUE(read.ok()) << read.error().message;
    ExpectSame(*read);
  }
  EXPECT_FALSE(WriteLabelFusion(document_, {}, out).ok());
}

TEST_F(PoseExchange, LabelFusionsOwnFileIsRead) {
  const auto file = folder_.path() / "registration_result.yaml";
  WriteText(file,
            "frame: world\ndrill:\n  filename: object-meshes/drill.vtp\n"
            "  pose:\n  - [0.1, -0.2, 0.7]\n  - [0.0, 1.0, 0.0, 0.0]\n");
  const auto read = ReadLabelFusion(document_, Inputs(), file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->instances.size(), 1u);
  const Eigen::Isometry3d cam_from_drill =
      ScanFromCam(document_, *sequence_, 0)->inverse() * read->instances[0].scan_from_object;
  // w first: half a turn about x.
  EXPECT_LT(
      (cam_from_drill.linear() - Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix()).norm(),
      1e-12);
}

TEST_F(PoseExchange, FramePosesComeBack) {
  const auto file = folder_.path() / "poses.json";
  ASSERT_TRUE(WriteFramePoses(document_, Inputs(), file).ok());
  const auto read = ReadFramePoses(document_, Inputs(), file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ExpectSame(*read);
  EXPECT_EQ(ReadJson(file).value()["frames"].size(), 3u);
}

TEST_F(PoseExchange, BopComesBack) {
  ASSERT_TRUE(WriteBop(document_, Inputs(), folder_.path() / "bop", {}).ok());
  const auto read = ReadBop(folder_.path() / "bop");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ExpectSame(*read, false);
}

TEST_F(PoseExchange, ScaledObjectsComeBackFromVismaAndBop) {
  document_.instances.resize(3);
  document_.instances[1].scale = 1.05;
  document_.instances[2].scale = 0.9321;
  const auto model_of = [&](int i) {
    return document_.instances[static_cast<std::size_t>(i)].model;
  };
  ExportRequest request;
  request.frame = PoseFrame::kScan;
  for (const char* format : {"visma", "bop"}) {
    SCOPED_TRACE(format);
    request.format = format;
    request.out = folder_.path() / format;
    const Status written = ExportAnnotation(document_, Inputs(), "", request, {});
    ASSERT_TRUE(written.ok()) << written.error().message;
    auto read = request.format == "bop" ? ReadBop(request.out) : ReadVisma(request.out);
    ASSERT_TRUE(read.ok()) << read.error().message;
    TakeScalesFromNames(*models_, read->instances);
    ASSERT_EQ(read->instances.size(), 3u);
    for (int i = 0; i < 3; ++i) {
      const AnnotatedInstance& wanted = document_.instances[static_cast<std::size_t>(i)];
      const auto same = [&](const AnnotatedInstance& instance) {
        return instance.model == wanted.model && std::abs(instance.scale - wanted.scale) < 1e-9 &&
               (instance.scan_from_object.matrix() - wanted.scan_from_object.matrix()).norm() <
                   1e-6;
      };
      EXPECT_TRUE(std::any_of(read->instances.begin(), read->instances.end(), same)) << model_of(i);
    }
  }
  // The model that BOP has of it is as large as it is.
  const nlohmann::json sizes = ReadJson(folder_.path() / "bop/models/models_info.json").value();
  const nlohmann::json names =
      ReadJson(folder_.path() / "bop/models/plumbline_models.json").value();
  int scaled = 0;
  for (const auto& [key, name] : names.items()) {
    if (name["name"] != ScaledModelName(model_of(1), 1.05)) continue;
    ++scaled;
    const double size_mm = 1000.0 * models_->model(*models_->Find(model_of(1))).bounds.sizes().x();
    EXPECT_NEAR(sizes[key]["size_x"].get<double>(), 1.05 * size_mm, 0.01);
  }
  EXPECT_EQ(scaled, 1);
}

TEST_F(PoseExchange, NamesThatOnlyLookScaledStayAsTheyAre) {
  std::vector<AnnotatedInstance> instances(3);
  instances[0].model = "chair_xl";
  instances[1].model = "unheard_of_x1.0500";
  instances[2].model = "chair_x-1";
  TakeScalesFromNames(*models_, instances);
  for (const AnnotatedInstance& instance : instances) EXPECT_EQ(instance.scale, 1);
}

TEST_F(PoseExchange, BopHasMasksAndSymmetriesInMillimetres) {
  // A crate 2 m before the first camera, a chair behind it.
  const Eigen::Isometry3d scan_from_cam = *ScanFromCam(document_, *sequence_, 0);
  document_.instances.resize(2);
  document_.instances[0].model = "table";
  document_.instances[0].scan_from_object = scan_from_cam * Eigen::Translation3d(0, 0, 2);
  document_.instances[1].model = "chair";
  document_.instances[1].scan_from_object = scan_from_cam * Eigen::Translation3d(0, 0, -5);
  ExchangeInputs inputs = Inputs();
  inputs.frames = {0};
  ASSERT_TRUE(WriteBop(document_, inputs, folder_.path() / "bop", {}).ok());
  const auto scene = folder_.path() / "bop" / "test" / "000000";
  const nlohmann::json info = ReadJson(scene / "scene_gt_info.json").value()["0"];
  EXPECT_GT(info[0]["px_count_visib"].get<int>(), 50);
  EXPECT_EQ(info[1]["px_count_all"].get<int>(), 0);
  EXPECT_TRUE(std::filesystem::exists(scene / "mask_visib" / "000000_000000.png"));
  EXPECT_TRUE(std::filesystem::exists(scene / "rgb" / "000000.png"));
  const auto shown = VisibleInstances(document_, inputs, 0);
  ASSERT_TRUE(shown.ok()) << shown.error().message;
  const cv::Mat first = *shown == 1;
  EXPECT_EQ(cv::countNonZero(first), info[0]["px_count_visib"].get<int>()) << "as it is previewed";
  EXPECT_EQ(cv::countNonZero(*shown == 2), 0);
  document_.instances[0].model = "nothing known";
  EXPECT_THAT(VisibleInstances(document_, inputs, 0).error().message,
              testing::HasSubstr("is not in the database"));
  document_.instances[0].model = "table";
  const nlohmann::json models =
      ReadJson(folder_.path() / "bop" / "models" / "models_info.json").value();
  const auto table = models[std::to_string(models_->Find("table")->value + 1)];
  EXPECT_NEAR(table["size_x"].get<double>(), 1300, 0.01);
  EXPECT_EQ(table["symmetries_discrete"].size(), 1u);
  const nlohmann::json truth = ReadJson(scene / "scene_gt.json").value()["0"][0];
  // The middle of the table's box is 0.37 m above its origin; boxes are single precision.
  EXPECT_NEAR(truth["cam_t_m2c"][2].get<double>(), 2370, 1e-3);
}

TEST_F(PoseExchange, MillimetresWhereMetresBelongAreWarnedOf) {
  for (AnnotatedInstance& instance : document_.instances) {
    instance.scan_from_object.translation() *= 1000;
  }
  const auto file = folder_.path() / "ground_truth.json";
  ASSERT_TRUE(WriteGroundTruthOf(document_, PoseFrame::kScan, file).ok());
  const auto read = ReadGroundTruthPoses(file);
  ASSERT_TRUE(read.ok());
  ASSERT_EQ(read->warnings.size(), 1u);
  EXPECT_THAT(read->warnings[0], testing::HasSubstr("are these millimetres?"));
}

TEST_F(PoseExchange, MetresWhereMillimetresBelongAreWarnedOf) {
  ASSERT_TRUE(WriteBop(document_, Inputs(), folder_.path() / "bop", {}).ok());
  const auto file = folder_.path() / "bop" / "test" / "000000" / "scene_gt.json";
  nlohmann::json truth = ReadJson(file).value();
  for (auto& [image, entries] : truth.items()) {
    for (nlohmann::json& entry : entries) {
      for (nlohmann::json& number : entry["cam_t_m2c"]) number = number.get<double>() / 1000;
    }
  }
  ASSERT_TRUE(WriteJson(file, truth).ok());
  const auto read = ReadBop(folder_.path() / "bop");
  ASSERT_TRUE(read.ok());
  ASSERT_FALSE(read->warnings.empty());
  EXPECT_THAT(read->warnings.back(), testing::HasSubstr("are these metres?"));
}

TEST_F(PoseExchange, DamagedFilesAreNamed) {
  WriteText(folder_.path() / "fragments" / "alignment.json", R"({"chair_0": [1, 2, 3]})");
  const auto visma = ReadVisma(folder_.path() / "fragments");
  ASSERT_FALSE(visma.ok());
  EXPECT_THAT(visma.error().message, testing::HasSubstr("'chair_0' has no rigid pose"));
  WriteText(folder_.path() / "fragments" / "alignment.json",
            R"({"chair_0": [1, 0, 0, 1e300, 0, 1, 0, 0, 0, 0, 1, 0]})");
  EXPECT_THAT(ReadVisma(folder_.path() / "fragments").error().message,
              testing::HasSubstr("within 1000 km"));
  WriteText(folder_.path() / "fragments" / "alignment.json",
            R"({"chair_0": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]})");
  WriteText(folder_.path() / "fragments" / "objects.json", "[]");
  EXPECT_THAT(ReadVisma(folder_.path() / "fragments").error().message,
              testing::HasSubstr("must hold a list 'entries'"));
  const auto yaml = folder_.path() / "a.yaml";
  WriteText(yaml, "drill: {pose: [[0, 0], [1, 0, 0, 0]]}\n");
  EXPECT_FALSE(ReadLabelFusion(document_, Inputs(), yaml).ok());
  WriteText(yaml, "drill: {pose: [[1e300, 0, 0], [1, 0, 0, 0]]}\n");
  EXPECT_THAT(ReadLabelFusion(document_, Inputs(), yaml).error().message,
              testing::HasSubstr("within 1000 km"));
  WriteText(yaml, "drill: {pose: [[");
  EXPECT_EQ(ReadLabelFusion(document_, Inputs(), yaml).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(ReadBop(folder_.path()).error().code, ErrorCode::kNotFound);
}

TEST_F(PoseExchange, ValuesOfTheWrongTypeAreErrorsThatNameTheFile) {
  const auto poses = folder_.path() / "poses.json";
  for (const char* text : {R"({"frames": [0.5]})", R"({"frames": [{"frame": "1"}]})",
                           R"({"frames": [{"frame": 1e99, "objects": []}]})",
                           R"({"frames": [{"frame": 0, "objects": [[]]}]})",
                           R"({"frames": [{"frame": 0, "objects": 3}]})"}) {
    WriteText(poses, text);
    const auto read = ReadFramePoses(document_, Inputs(), poses);
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_EQ(read.error().code, ErrorCode::kInvalidInput) << text;
    EXPECT_THAT(read.error().message, testing::HasSubstr("poses.json")) << text;
  }
  const auto scene = folder_.path() / "odd" / "test" / "000000";
  std::filesystem::create_directories(scene);
  const std::string camera =
      R"({"1": {"cam_R_w2c": [1, 0, 0, 0, 1, 0, 0, 0, 1], "cam_t_w2c": [0, 0, 0]}})";
  for (const char* text :
       {"[[]]", R"({"1": [[]]})", R"({"1": 5})", R"({"1": [{"obj_id": "x"}]})"}) {
    WriteText(scene / "scene_gt.json", text);
    for (const std::string& cameras : {camera, std::string("[[]]"), std::string(R"({"1": []})")}) {
      WriteText(scene / "scene_camera.json", cameras);
      const auto read = ReadBop(folder_.path() / "odd");
      ASSERT_FALSE(read.ok()) << text << " " << cameras;
      EXPECT_THAT(read.error().message, testing::HasSubstr("000000")) << text;
    }
  }
}

TEST_F(PoseExchange, NamesThatAreNoFileNamesAreNotWrittenElsewhere) {
  document_.instances[0].id = "../../chair_0";
  const Status written = WriteVisma(document_, models_.get(), folder_.path() / "a" / "b");
  ASSERT_FALSE(written.ok());
  EXPECT_THAT(written.error().message,
              testing::HasSubstr("'../../chair_0' cannot be the name of a file"));
}

class AnnotationCheck : public PoseExchange {
 protected:
  /// Upright on the floor of a z-up scan, far from one another.
  void SetUp() override {
    PoseExchange::SetUp();
    document_.gravity_in_scan = {0, 0, -1};
    document_.floor_in_scan = Eigen::Vector4d(0, 0, 1, 0);
    for (std::size_t i = 0; i < document_.instances.size(); ++i) {
      document_.instances[i].scan_from_object =
          Eigen::Isometry3d(Eigen::Translation3d(3.0 * static_cast<double>(i), 0, 0));
    }
  }
  std::vector<std::string> Kinds() const {
    std::vector<std::string> kinds;
    for (const auto& finding : CheckAnnotations(document_, {models_.get(), nullptr, {}})) {
      kinds.push_back(finding.kind);
    }
    return kinds;
  }
  Eigen::Isometry3d& Pose(std::size_t i) { return document_.instances[i].scan_from_object; }
};

TEST_F(AnnotationCheck, FindsNothingWhereAllIsWell) { EXPECT_TRUE(Kinds().empty()); }

TEST_F(AnnotationCheck, FindsTiltedFloatingAndSunkObjects) {
  Pose(0).linear() = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()).toRotationMatrix();
  Pose(1).translation().z() = 0.05;
  Pose(2).translation().z() = -0.05;
  EXPECT_THAT(Kinds(), testing::ElementsAre("tilted", "floating", "sunk"));
  document_.instances[0].may_tilt = true;
  EXPECT_THAT(Kinds(), testing::ElementsAre("floating", "sunk")) << "it is meant so";
}

TEST_F(AnnotationCheck, FindsDuplicatesAndUnknownModels) {
  Pose(4) = Pose(0);  // both of the first model
  Pose(4).translation().y() = 0.02;
  document_.instances[5].model = "piano";
  EXPECT_THAT(Kinds(), testing::UnorderedElementsAre("duplicate", "unknown_model"));
}

TEST_F(AnnotationCheck, FindsObjectsThatReachIntoOneAnother) {
  ASSERT_EQ(document_.instances[3].model, "crate");
  Pose(1).translation() = Pose(3).translation() + Eigen::Vector3d(0.25, 0.2, 0);  // a leg in it
  EXPECT_THAT(Kinds(), testing::ElementsAre("interpenetrating"));
  Pose(1).translation() = Pose(3).translation() + Eigen::Vector3d(0.5, 0.2, 0);
  EXPECT_TRUE(Kinds().empty());
}

TEST_F(AnnotationCheck, FindsFramesWithoutPose) {
  const auto file = folder_.path() / "walk" / "trajectory.txt";
  std::string trajectory = ReadFile(file).value();
  trajectory.erase(trajectory.rfind('\n', trajectory.size() - 2) + 1);
  ASSERT_TRUE(WriteFileAtomically(file, trajectory).ok());
  const auto sequence = OpenSequence(folder_.path() / "walk");
  ASSERT_TRUE(sequence.ok()) << sequence.error().message;
  const auto findings = CheckAnnotations(document_, {models_.get(), sequence->get(), {}});
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings[0].kind, "missing_frames");
  EXPECT_EQ(findings[0].amount, 1);
  EXPECT_EQ(findings[0].unit, "frames");
}

}  // namespace
}  // namespace plumbline
