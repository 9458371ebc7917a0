// SPDX-License-Identifier: Apache-2.0
// `plumbline info` and `plumbline convert` on samples of public data sets.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/ground_truth.h"
#include "engine/models/model_database.h"
#include "tests/engine/dataset/data_set_sample.h"
#include "tests/support/program_run.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

class ConvertVerb : public DataSetSample {
 protected:
  nlohmann::json Info(const std::string& path) {
    const ProgramRun run = RunProgram("info " + path + " --json - 2>&1", folder());
    EXPECT_EQ(run.exit_code, 0) << run.output;
    return nlohmann::json::parse(run.output, nullptr, false);
  }
};

TEST_F(ConvertVerb, EveryDataSetIsDescribedAndConverted) {
  const std::array<std::array<const char*, 3>, 11> kSamples = {{
      {"seven_scenes", "redkitchen/seq-01", "7-scenes"},
      {"tum_rgbd", "rgbd_dataset_freiburg3_sample", "tum-rgbd"},
      {"icl_nuim", "living_room_traj2_frei_png", "icl-nuim"},
      {"ros_bag", "sample.bag", "rosbag"},
      {"kitti_raw", "2011_09_26/2011_09_26_drive_0005_sync", "kitti-raw"},
      {"kitti_odometry", "dataset/sequences/04", "kitti-odometry"},
      {"scannet_sens", "scans/scene0042_01/scene0042_01.sens", "scannet"},
      {"scannet_extracted", "scans/scene0042_01/exported", "scannet"},
      {"visma", "clutter1", "visma"},
      {"scenenn", "123", "scenenn"},
      {"bop_scene", "sample/train_real/000012", "bop"},
  }};
  for (const auto& [sample, path, format] : kSamples) {
    SCOPED_TRACE(sample);
    ASSERT_NO_FATAL_FAILURE(Write(sample));
    if (IsSkipped()) return;
    const nlohmann::json before = Info(path);
    EXPECT_EQ(before["format"]["name"], format);
    const bool tells_truth = std::string(format) == "kitti-raw" || std::string(format) == "visma" ||
                             std::string(format) == "bop";
    EXPECT_EQ(before.contains("ground_truth"), tells_truth);
    EXPECT_EQ(before["images"]["looked_at"], before["images"]["readable"]);
    const std::string out = "out_" + std::string(sample);
    const ProgramRun run =
        RunProgram("convert " + std::string(path) + " --out " + out + " --json - 2>&1", folder());
    ASSERT_EQ(run.exit_code, 0) << run.output;
    const nlohmann::json written = nlohmann::json::parse(run.output);
    EXPECT_EQ(written["skipped"], 0);
    const nlohmann::json after = Info(out);
    EXPECT_EQ(after["format"]["name"], "plumbline");
    EXPECT_EQ(after["frames"]["count"], before["frames"]["count"]);
    EXPECT_EQ(after["poses"]["frames"], before["poses"]["frames"]);
    EXPECT_EQ(after["imu"].is_null(), before["imu"].is_null());
    if (tells_truth) {
      EXPECT_THAT(after["companions"], testing::Contains("ground truth"));
    }
  }
}

TEST_F(ConvertVerb, CutsTheInstancesOfSceneNnOutOfItsMesh) {
  ASSERT_NO_FATAL_FAILURE(Write("scenenn"));
  if (IsSkipped()) return;
  const ProgramRun run = RunProgram("convert 123 --out ours 2>&1", folder());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("less than 50 triangles of 'table_9'"));
  const auto models = ModelDatabase::Load(folder() / "ours/models");
  ASSERT_TRUE(models.ok()) << models.error().message;
  const auto truth = ReadGroundTruth(folder() / "ours/ground_truth.json");
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  ASSERT_EQ(truth->instances.size(), 1u);
  const GroundTruthInstance& chair = truth->instances[0];
  EXPECT_EQ(chair.id, "chair_7");
  EXPECT_EQ(chair.category, "chair");
  // On the floor at y = 1.2, below the middle of its box; up is -y.
  EXPECT_LT((chair.world_from_object.translation() - Eigen::Vector3d(0.75, 1.2, 2.25)).norm(),
            1e-4);
  EXPECT_LT((chair.world_from_object.linear().col(2) - Eigen::Vector3d(0, -1, 0)).norm(), 1e-4);
  const auto sequence = Open("ours");
  EXPECT_LT((*sequence->gravity_in_world() - Eigen::Vector3d(0, 1, 0)).norm(), 1e-4);
  EXPECT_NEAR((*sequence->floor_in_world())[3], 1.2, 1e-4);
}

TEST_F(ConvertVerb, PosesModelsAsTheyWereBuilt) {
  ASSERT_NO_FATAL_FAILURE(Write("visma"));
  if (IsSkipped()) return;
  // A box, y up, its foot at (1.2, -0.5, 2.3).
  std::string box;
  for (int i = 0; i < 8; ++i)
    box += fmt::format("v {} {} {}\n", i & 1 ? 1.5 : 0.9, i & 2 ? 0.4 : -0.5, i & 4 ? 2.6 : 2.0);
  for (const char* face : {"1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"})
    box += fmt::format("f {}\n", face);
  ASSERT_TRUE(WriteFileAtomically(folder() / "swivel_chair.obj", box).ok());
  const ProgramRun built = RunProgram(
      "models build swivel_chair.obj --out db --unit m --up y --front +x 2>&1", folder());
  ASSERT_EQ(built.exit_code, 0) << built.output;
  const ProgramRun run =
      RunProgram("convert clutter1 --out posed --models db --json - 2>&1", folder());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("no model 'Aeron' was built of a mesh file"));
  ASSERT_EQ(RunProgram("convert clutter1 --out plain 2>&1", folder()).exit_code, 0);
  const auto posed = ReadGroundTruth(folder() / "posed/ground_truth.json");
  const auto plain = ReadGroundTruth(folder() / "plain/ground_truth.json");
  ASSERT_TRUE(posed.ok() && plain.ok());
  EXPECT_LT((posed->instances[0].world_from_object.translation() -
             plain->instances[0].world_from_object * Eigen::Vector3d(1.2, -2.3, -0.5))
                .norm(),
            1e-6);
  const ProgramRun none =
      RunProgram("convert clutter1 --out none --models clutter1 2>&1", folder());
  EXPECT_NE(none.exit_code, 0);
  EXPECT_THAT(none.output, HasSubstr("models.json"));
  ASSERT_TRUE(WriteFileAtomically(folder() / "db/models.json",
                                  R"({"models": [{"name": "a", "source": {"origin_m": [1, 2]}}]})")
                  .ok());
  const ProgramRun odd = RunProgram("convert clutter1 --out odd --models db 2>&1", folder());
  EXPECT_NE(odd.exit_code, 0);
  EXPECT_THAT(odd.output, HasSubstr("describes the file of 'a' by something else"));
}

TEST_F(ConvertVerb, WritesTumRgbdAndRefusesWhatItCannot) {
  ASSERT_NO_FATAL_FAILURE(Write("icl_nuim"));
  if (IsSkipped()) return;
  const std::string source = "living_room_traj2_frei_png";
  ASSERT_EQ(RunProgram("convert " + source + " --to tum-rgbd --out tum 2>&1", folder()).exit_code,
            0);
  EXPECT_EQ(Info("tum")["format"]["name"], "tum-rgbd");
  EXPECT_EQ(Info("tum")["frames"]["count"], 12);
  const ProgramRun again =
      RunProgram("convert " + source + " --to tum-rgbd --out tum 2>&1", folder());
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.output, HasSubstr("new or empty"));
  EXPECT_EQ(RunProgram("convert " + source + " --to 7-scenes --out a 2>&1", folder()).exit_code, 2);
  EXPECT_EQ(RunProgram("convert nowhere --out a 2>&1", folder()).exit_code, 1);
}

}  // namespace
}  // namespace plumbline
