// SPDX-License-Identifier: Apache-2.0
// A run's map in the formats of posed objects, as a script exports it.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/dataset/scannet_sequence.h"
#include "engine/dataset/sequence_formats.h"
#include "engine/models/mesh_file.h"
#include "tests/support/program_run.h"
#include "tests/support/recorded_room.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

class ExportRoom : public testing::Test {
 protected:
  void SetUp() override { WriteRecordedRoom(folder_.path()); }
  void Export(const std::string& arguments, int exit_code = 0) {
    const ProgramRun run = RunProgram("export room.plb " + arguments + " 2>&1", folder_.path());
    output_ = run.output;
    ASSERT_EQ(run.exit_code, exit_code) << run.output;
  }
  nlohmann::json Json(const char* name) const { return ReadJson(folder_.path() / name).value(); }

  TemporaryFolder folder_;
  std::string output_;
};

TEST_F(ExportRoom, GltfHoldsTheConfirmedObjects) {
  Export("--format gltf --out room.glb --up z");
  EXPECT_THAT(output_, testing::HasSubstr("room.glb: 2 instances"));
  const auto mesh = ReadMesh(folder_.path() / "room.glb");
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  // The chair at (0, 0, 3), the table at (0.1, 0.1, 3.2), 1.3 m wide and 0.74 m high.
  EXPECT_NEAR(BoundingBox(*mesh).min().z(), 3, 1e-5);
  EXPECT_NEAR(BoundingBox(*mesh).max().z(), 3.94, 1e-5);
  EXPECT_NEAR(BoundingBox(*mesh).max().x(), 0.75, 1e-5);
  Export("--format gltf --out smoothed.glb --up z --smoothed");
  const auto smoothed = ReadMesh(folder_.path() / "smoothed.glb");
  ASSERT_TRUE(smoothed.ok()) << smoothed.error().message;
  EXPECT_NEAR(BoundingBox(*smoothed).max().x(), 0.775, 1e-5) << "the table alone, 2.5 cm further";
}

TEST_F(ExportRoom, CocoLabelsTheFramesOfTheRun) {
  Export("--format coco --out coco");
  const nlohmann::json coco = Json("coco/instances.json");
  EXPECT_EQ(coco["images"].size(), 4u);
  ASSERT_FALSE(coco["annotations"].empty());
  EXPECT_EQ(coco["annotations"][0]["instance"], "chair_1") << "model and number in the run";
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "coco/masks/000003.png"));
  Export("--format coco --out few --frames 1:3");
  EXPECT_EQ(Json("few/instances.json")["images"].size(), 2u);
}

TEST_F(ExportRoom, EveryFormatIsWritten) {
  Export("--format bop --out bop --frames 0:1");
  EXPECT_EQ(Json("bop/test/000000/scene_gt.json")["0"].size(), 2u);
  Export("--format scan2cad --out scan2cad");
  EXPECT_EQ(Json("scan2cad/full_annotations.json")[0]["n_aligned_models"], 2);
  Export("--format labelfusion --out labelfusion");
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "labelfusion/object_data.yaml"));
  Export("--format poses --out poses.json");
  EXPECT_EQ(Json("poses.json")["frames"].size(), 4u);
}

TEST_F(ExportRoom, BopIsReadBackAsASequenceWithItsTruth) {
  Export("--format bop --out bop");
  const auto scene = OpenSequence(folder_.path() / "bop/test/000000");
  const auto walk = OpenSequence(folder_.path() / "walk");
  ASSERT_TRUE(scene.ok() && walk.ok()) << (scene.ok() ? "" : scene.error().message);
  ASSERT_EQ((*scene)->num_frames(), (*walk)->num_frames());
  EXPECT_EQ((*scene)->camera(), (*walk)->camera());
  std::vector<std::string> warnings;
  const auto truth = ReadTruthOf(**scene, warnings);
  ASSERT_TRUE(truth.ok() && truth->has_value());
  ASSERT_EQ((*truth)->instances.size(), 2u);
  // Wherever their world lies, the chair stands as far from each camera as in ours.
  for (int i = 0; i < (*walk)->num_frames(); ++i) {
    const Eigen::Vector3d chair = (*scene)->world_from_cam(i)->inverse() *
                                  (*truth)->instances[0].world_from_object.translation();
    const Eigen::Vector3d ours = (*walk)->world_from_cam(i)->inverse() * Eigen::Vector3d(0, 0, 3);
    EXPECT_LT((chair - ours).norm(), 1e-5) << i << ": " << chair.transpose();
  }
}

TEST_F(ExportRoom, Scan2CadIsReadBackWhereTheObjectsStand) {
  Export("--format scan2cad --out scan2cad");
  const std::string scan = Json("scan2cad/full_annotations.json")[0]["id_scan"];
  std::vector<std::string> warnings;
  const auto truth =
      ReadScan2Cad(folder_.path() / "scan2cad/full_annotations.json", {}, scan, warnings);
  ASSERT_TRUE(truth.ok() && truth->has_value()) << (truth.ok() ? "" : truth.error().message);
  ASSERT_EQ((*truth)->instances.size(), 2u);
  const GroundTruthInstance& chair = (*truth)->instances[0];
  EXPECT_LT((chair.world_from_object.translation() - Eigen::Vector3d(0, 0, 3)).norm(), 1e-5)
      << chair.world_from_object.translation().transpose();
  EXPECT_LT((chair.world_from_object.linear().col(2) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-6);
  EXPECT_NEAR(chair.size_m->z(), 0.9, 1e-5);
}

TEST_F(ExportRoom, WhatIsMissingIsSaid) {
  Export("--format visma --out visma", 2);
  Export("--format csv --out tables --smoothed", 1);
  EXPECT_THAT(output_, testing::HasSubstr("--smoothed goes with"));
  std::filesystem::rename(folder_.path() / "walk", folder_.path() / "moved");
  Export("--format coco --out coco", 1);
  EXPECT_THAT(output_, testing::HasSubstr("--sequence DIR"));
  Export("--format coco --out coco --sequence moved");
  Export("--format gltf --out room.gltf", 1);
  EXPECT_THAT(output_, testing::HasSubstr("must end in .glb"));
}

TEST_F(ExportRoom, WhatIsReplacedIsKept) {
  Export("--format gltf --out room.glb");
  Export("--format gltf --out room.glb --up z");
  EXPECT_THAT(output_, testing::HasSubstr("what was there is kept as"));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "room.glb.bak"));
}

}  // namespace
}  // namespace plumbline
