// SPDX-License-Identifier: Apache-2.0
// The commands of `annotate` as a script meets them.

#include <cmath>

#include "engine/models/mesh_file.h"
#include "tests/app/annotate_command.h"
#include "tests/support/furniture_models.h"
#include "tests/support/meshes.h"
#include "tests/support/tiny_sequence.h"

namespace plumbline {
namespace {

class AnnotateVerb : public AnnotateCommand {
 protected:
  void SetUp() override {
    WriteTinySequence(folder_.path() / "walk");
    std::filesystem::create_directory(folder_.path() / "models");
    ASSERT_TRUE(WritePly(folder_.path() / "models" / "chair.ply", MakeChair(true)).ok());
    Write("models/models.json", R"({"units": "m", "models": [{"name": "chair", "file": "chair.ply",
        "category": "chair", "support": "floor"}]})");
    Write("edits.json", R"([
        {"edit": "inputs", "scan": "", "models": "models", "sequence": "walk"},
        {"edit": "gravity", "gravity": [0, 0, -1], "floor": [0, 0, 1, 0]},
        {"edit": "add", "instance": {"id": "chair_0", "model": "chair", "category": "chair",
         "scan_from_object": [[1,0,0,0.5],[0,1,0,0.1],[0,0,1,0],[0,0,0,1]]}},
        {"edit": "add", "instance": {"id": "chair_1", "model": "chair", "category": "chair",
         "scan_from_object": [[0,-1,0,2.5],[1,0,0,0.1],[0,0,1,0],[0,0,0,1]]}},
        {"edit": "change", "id": "chair_1", "quality": "coarse", "note": "back only"}])");
    ASSERT_EQ(Run("apply room.json edits.json --create --annotator Ada"), 0) << Output();
  }
};

TEST_F(AnnotateVerb, AppliesEditsAndSaves) {
  const nlohmann::json project = Json("room.json");
  ASSERT_EQ(project["instances"].size(), 2u);
  EXPECT_EQ(project["instances"][1]["annotator"], "Ada");
  EXPECT_EQ(project["instances"][1]["quality"], "coarse");
  EXPECT_EQ(project["models"], "models");
}

TEST_F(AnnotateVerb, AScriptWithAMistakeChangesNothing) {
  const std::string before = ReadFile(folder_.path() / "room.json").value();
  Write("edits.json", R"([{"edit": "remove", "id": "chair_0"}, {"edit": "remove", "id": "sofa"}])");
  EXPECT_EQ(Run("apply room.json edits.json"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("edit 2: there is no instance 'sofa'"));
  EXPECT_EQ(ReadFile(folder_.path() / "room.json").value(), before);
  EXPECT_EQ(Run("apply none.json edits.json"), 1);
  EXPECT_EQ(Run("apply room.json"), 2);
}

TEST_F(AnnotateVerb, SaysWhatOfAJournalCannotBeReadAndKeepsIt) {
  const std::string project = ReadFile(folder_.path() / "room.json").value();
  const nlohmann::json header = {{"journal", "killed"}, {"base", HashHex(project)}};
  Write("room.json.journal", header.dump() + R"(
{"kind": "do", "label": "Remove chair_0", "edit": {"edit": "remove", "id": "chair_0"}}
{"kind": "do", "label": "Paint chair_1", "edit": {"edit": "paint", "id": "chair_1"}}
{"kind": "do", "label": "Change chair_1", "edit": {"edit": "change", "id": "chair_1", "note": "all"}}
)");
  Write("edits.json", R"([{"edit": "change", "id": "chair_1", "annotator": "Grace"}])");
  EXPECT_EQ(Run("apply room.json edits.json"), 0);
  EXPECT_THAT(Output(), testing::HasSubstr("1 of 3 unsaved edits of 'room.json' could not be "
                                           "repeated and are kept in "
                                           "'room.json.journal.unreadable-"));
  const nlohmann::json saved = Json("room.json")["instances"];
  ASSERT_EQ(saved.size(), 1u);
  EXPECT_EQ(saved[0]["note"], "all");
  EXPECT_EQ(saved[0]["annotator"], "Grace");
}

TEST_F(AnnotateVerb, WhatIsExportedIsReadAgain) {
  for (const std::string format : {"ground_truth", "visma", "bop", "labelfusion", "poses"}) {
    ASSERT_EQ(Run("export room.json --format " + format + " --out " + format + " --frames 0:4:2"),
              0)
        << Output();
    // A project of its own that knows the sequence and the models.
    Write("inputs.json",
          R"([{"edit": "inputs", "scan": "", "models": "models", "sequence": "walk"}])");
    ASSERT_EQ(Run("apply again_" + format + ".json inputs.json --create"), 0) << Output();
    ASSERT_EQ(Run("import again_" + format + ".json --format " + format + " --from " + format), 0)
        << Output();
    const nlohmann::json wanted = Json("room.json"),
                         read = Json(("again_" + format + ".json").c_str());
    ASSERT_EQ(read["instances"].size(), 2u) << format;
    for (int i = 0; i < 2; ++i) {
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 4; ++c) {
          EXPECT_NEAR(read["instances"][i]["scan_from_object"][r][c].get<double>(),
                      wanted["instances"][i]["scan_from_object"][r][c].get<double>(), 1e-9)
              << format;
        }
      }
    }
  }
}

/// Three chairs each, of which two stand apart by 2 cm and one by 4; the second has one more.
class TwoAnnotators : public AnnotateVerb {
 protected:
  void SetUp() override {
    AnnotateVerb::SetUp();
    const auto project = [&](const std::string& name, const std::vector<double>& xs) {
      nlohmann::json edits = {
          {{"edit", "inputs"}, {"scan", ""}, {"models", "models"}, {"sequence", ""}},
          {{"edit", "gravity"}, {"gravity", {0, 0, -1}}, {"floor", {0, 0, 1, 0}}}};
      for (std::size_t i = 0; i < xs.size(); ++i) {
        const nlohmann::json pose = {{1, 0, 0, xs[i]}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
        edits.push_back({{"edit", "add"},
                         {"instance",
                          {{"id", "chair_" + std::to_string(i)},
                           {"model", "chair"},
                           {"category", "chair"},
                           {"scan_from_object", pose}}}});
      }
      Write("edits.json", edits.dump());
      ASSERT_EQ(Run("apply " + name + " edits.json --create"), 0) << Output();
    };
    project("ada.json", {0, 2, 4});
    project("grace.json", {0.02, 2.02, 3.96, 9});
  }
};

TEST_F(TwoAnnotators, AreComparedObjectByObject) {
  ASSERT_EQ(Run("agree ada.json grace.json --json agreement.json"), 0) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("chair_3            only in the second"));
  const nlohmann::json json = Json("agreement.json");
  ASSERT_EQ(json["objects"].size(), 3u);
  EXPECT_NEAR(json["objects"][2]["horizontal_m"], 0.04, 1e-12);
  EXPECT_EQ(json["only_in_second"], nlohmann::json::array({"chair_3"}));
  // Of both horizontal coordinates: sqrt((0.02^2 + 0.02^2 + 0.04^2) / (4 * 3)).
  EXPECT_NEAR(json["all"]["horizontal_std_m"], 0.0141421356, 1e-9);
  EXPECT_NEAR(json["all"]["position_std_m"], 0.02, 1e-12);
  ASSERT_EQ(Run("export grace.json --format ground_truth --frame level --out level.json"), 0);
  ASSERT_EQ(Run("agree ada.json level.json --second-frame level --json again.json"), 0) << Output();
  EXPECT_EQ(Json("again.json")["all"], json["all"]);
}

TEST_F(TwoAnnotators, SayHowWellTheTruthIsKnown) {
  ASSERT_EQ(Run("export ada.json --format ground_truth --out truth.json"), 0) << Output();
  ASSERT_EQ(Run("export ada.json --format ground_truth --out truth.json --second grace.json"), 0)
      << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("chair_0 (known to 2.0 cm 0.0"));
  const nlohmann::json instances = Json("truth.json")["instances"];
  ASSERT_EQ(instances.size(), 3u);
  EXPECT_NEAR(instances[0]["position_std_m"], 0.02, 1e-9) << "pooled";
  EXPECT_NEAR(instances[2]["position_std_m"], 0.04 / std::sqrt(2), 1e-9) << "its own";
  EXPECT_NEAR(instances[0]["azimuth_std_deg"], 0, 1e-9);
  EXPECT_EQ(Run("export ada.json --format visma --out visma --second grace.json"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("cannot say how well a pose is known"));
}

TEST_F(AnnotateVerb, ListsTheScansOfAFolder) {
  Write("edits.json", R"([{"edit": "state", "state": {"stage": "to review", "annotator": "Ada",
      "note": "all chairs"}}, {"edit": "change", "id": "chair_0", "seconds_spent": 90}])");
  ASSERT_EQ(Run("apply room.json edits.json"), 0) << Output();
  ASSERT_TRUE(WritePly(folder_.path() / "hall.ply", MakeChair(true)).ok());
  ASSERT_EQ(Run("queue . --json queue.json"), 0) << Output();
  EXPECT_THAT(Output(),
              testing::HasSubstr("room.json  to review       2     1.5  Ada: all chairs"));
  const nlohmann::json queue = Json("queue.json");
  ASSERT_EQ(queue.size(), 2u) << "models are no scans";
  EXPECT_EQ(queue[0]["name"], "hall.ply");
  EXPECT_EQ(queue[0]["state"], "new");
  EXPECT_EQ(queue[1]["seconds"], 90);
  Write("edits.json", R"([{"edit": "state", "state": {"stage": "done", "annotator": "Ada",
      "reviewer": "Ada"}}])");
  EXPECT_EQ(Run("apply room.json edits.json"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("a second person reviews it"));
  EXPECT_EQ(Run("queue none"), 1);
}

TEST_F(AnnotateVerb, TakesTheObjectsOfARunAsDrafts) {
  Write("run.json", R"({"objects": [
      {"id": 4, "model": "chair", "category": "chair", "confirmed": true,
       "world_from_object": [[1,0,0,3],[0,1,0,1],[0,0,1,0],[0,0,0,1]]},
      {"id": 5, "model": "chair", "category": "chair", "confirmed": false,
       "world_from_object": [[1,0,0,7],[0,1,0,1],[0,0,1,0],[0,0,0,1]]}]})");
  // The sequence's world lies 10 m along x in the scan.
  Write("edits.json", R"([{"edit": "scene_alignment",
      "scan_from_world": [[1,0,0,10],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}])");
  ASSERT_EQ(Run("apply room.json edits.json"), 0) << Output();
  ASSERT_EQ(Run("import room.json --format run --from run.json --annotator Ada"), 0) << Output();
  const nlohmann::json read = Json("room.json");
  ASSERT_EQ(read["instances"].size(), 3u);
  const nlohmann::json& draft = read["instances"][2];
  EXPECT_EQ(draft["id"], "chair_2");
  EXPECT_EQ(draft["quality"], "coarse");
  EXPECT_EQ(draft["note"], "draft: object 4 of run.json");
  EXPECT_EQ(draft["scan_from_object"][0][3], 13);
  EXPECT_EQ(Run("import room.json --format run --from none.plb"), 1);
  EXPECT_EQ(Run("export room.json --format run --out again"), 2);
}

TEST_F(AnnotateVerb, RegistersASequenceToTheScanAndExportsWhereItIs) {
  // A quarter turn about up, and 3 m along x.
  Write("pairs.json", R"([{"in_scan": [3, 0, 0], "in_world": [0, 0, 0]},
      {"in_scan": [3, 2, 0.5], "in_world": [2, 0, 0.5]},
      {"in_scan": [2, 0, 1], "in_world": [0, 1, 1]}])");
  ASSERT_EQ(Run("register room.json --pairs pairs.json --json found.json"), 0) << Output();
  const nlohmann::json found = Json("found.json");
  EXPECT_LT(found["residuals"][1], 1e-6);
  const nlohmann::json pose = Json("room.json")["scan_from_world"];
  EXPECT_EQ(pose, found["scan_from_world"]);
  EXPECT_NEAR(pose[0][1], -1, 1e-7);
  EXPECT_NEAR(pose[0][3], 3, 1e-6);
  ASSERT_EQ(Run("export room.json --format visma --out visma"), 0) << Output();
  const nlohmann::json written = Json("visma/result_alignment.json")["T_ef_corvis"];
  ASSERT_EQ(written.size(), 12u);
  EXPECT_EQ(written[3], pose[0][3]);
  Write("one.json", R"([{"in_scan": [3, 0, 0], "in_world": [0, 0, 0]}])");
  EXPECT_EQ(Run("register room.json --pairs one.json"), 1);
  EXPECT_NE(Output().find("two pairs"), std::string::npos) << Output();
  Write("short.json", R"([{"in_scan": [3, 0], "in_world": [0, 0, 0]}])");
  EXPECT_EQ(Run("register room.json --pairs short.json"), 1);
  EXPECT_NE(Output().find("short.json', pair 1"), std::string::npos) << Output();
  Write("large.json", R"([{"in_scan": [3, 0, 0], "frame": 4e200, "pixel": [1, 1]}])");
  EXPECT_EQ(Run("register room.json --pairs large.json"), 1);
  EXPECT_NE(Output().find("large.json', pair 1"), std::string::npos) << Output();
  Write("object.json", R"({"in_scan": [3, 0, 0], "in_world": [0, 0, 0]})");
  EXPECT_EQ(Run("register room.json --pairs object.json"), 1);
  EXPECT_NE(Output().find("must be a list of pairs"), std::string::npos) << Output();
  Write("far.json", R"([{"in_scan": [3, 0, 0], "frame": 99999, "pixel": [1, 1]}])");
  EXPECT_EQ(Run("register room.json --pairs far.json"), 1);
  EXPECT_NE(Output().find("far.json': frame 99999 has no pose"), std::string::npos) << Output();
  EXPECT_NE(Run("register room.json"), 0) << "by what?";
}

TEST_F(AnnotateVerb, CutsAModelOutOfTheScan) {
  // A chair on a floor, both in many triangles; the floor reaches beyond the box.
  TriangleMesh scan;
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 40; ++k) {
      const auto x = static_cast<float>(i) * 0.05f - 1, y = static_cast<float>(k) * 0.05f - 1;
      Append(MakeParallelogram({x, y, 0}, {0.05f, 0, 0}, {0, 0.05f, 0}), scan);
    }
  }
  Append(MakeChair(true), scan);
  ASSERT_TRUE(WritePly(folder_.path() / "scan.ply", scan).ok());
  Write("crop.json", R"([
      {"edit": "inputs", "scan": "scan.ply", "models": "models", "sequence": ""},
      {"edit": "crop", "crop": {"id": "stool", "category": "chair",
       "box": {"center": [0, 0, 0.45], "size": [0.7, 0.7, 1.0]}}}])");
  ASSERT_EQ(Run("apply room.json crop.json --annotator Ada"), 0) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("stool: "));
  const nlohmann::json project = Json("room.json");
  ASSERT_EQ(project["instances"].size(), 3u);
  EXPECT_EQ(project["instances"][2]["id"], "stool_0");
  EXPECT_EQ(project["crops"][0]["annotator"], "Ada");
  EXPECT_EQ(Json("models/models.json")["models"][1]["name"], "stool");
  ASSERT_EQ(Run("check room.json --json -"), 0) << Output();
  EXPECT_THAT(Output(), testing::Not(testing::HasSubstr("crop")));
  EXPECT_EQ(Run("apply room.json crop.json"), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("there is a crop 'stool' already"));
}

TEST_F(AnnotateVerb, ChecksTheProject) {
  ASSERT_EQ(Run("check room.json --json check.json"), 0) << Output();
  EXPECT_EQ(Json("check.json")["findings"].size(), 0u);
  Write("edits.json", R"([{"edit": "change", "id": "chair_1",
      "scan_from_object": [[1,0,0,0.52],[0,1,0,0.1],[0,0,1,0.1],[0,0,0,1]]}])");
  ASSERT_EQ(Run("apply room.json edits.json"), 0) << Output();
  ASSERT_EQ(Run("check room.json --json check.json"), 0);
  EXPECT_THAT(Output(), testing::HasSubstr("chair_1 floats 0.100 m above the floor"));
  EXPECT_EQ(Json("check.json")["findings"][0]["kind"], "floating");
  EXPECT_FALSE(Json("check.json")["findings"][0].contains("accepted"));

  Write("accept.json", R"([{"edit": "accept", "finding": {"kind": "floating", "amount": 0.1,
      "unit": "m", "by": "Ada", "note": "on a box", "objects": [{"id": "chair_1", "model": "chair",
      "scan_from_object": [[1,0,0,0.52],[0,1,0,0.1],[0,0,1,0.1],[0,0,0,1]]}]}}])");
  ASSERT_EQ(Run("apply room.json accept.json"), 0) << Output();
  ASSERT_EQ(Run("check room.json --json check.json"), 0);
  EXPECT_THAT(Output(), testing::HasSubstr("(accepted by Ada: on a box)"));
  EXPECT_THAT(Output(), testing::HasSubstr("0 findings, 1 accepted findings"));
  EXPECT_EQ(Json("check.json")["findings"][0]["accepted"]["by"], "Ada");
  ASSERT_EQ(Run("export room.json --format ground_truth --out truth.json"), 0);
  EXPECT_THAT(Output(), testing::HasSubstr("1 accepted findings"));
  EXPECT_THAT(Output(), testing::Not(testing::HasSubstr("floats")));
  Write("back.json", R"([{"edit": "reopen", "kind": "floating", "instances": ["chair_1"]}])");
  ASSERT_EQ(Run("apply room.json back.json"), 0) << Output();
  ASSERT_EQ(Run("check room.json"), 0);
  EXPECT_THAT(Output(), testing::HasSubstr("1 findings"));
}

TEST_F(AnnotateVerb, AScaledObjectIsExportedAtItsSizeAndComesBack) {
  Write("edits.json", R"([{"edit": "change", "id": "chair_1", "scale": 1.05, "may_scale": true},
      {"edit": "state", "state": {"stage": "done", "annotator": "Ada"}}])");
  ASSERT_EQ(Run("apply room.json edits.json"), 0) << Output();
  ASSERT_EQ(Run("export room.json --format ground_truth --out truth.json"), 0) << Output();
  ASSERT_EQ(Run("import back.json --create --format ground_truth --from truth.json"), 0);
  double scale = 0;
  const nlohmann::json back = Json("back.json");
  for (const auto& instance : back["instances"]) {
    if (instance["id"] == "chair_1") scale = instance["scale"];
  }
  EXPECT_EQ(scale, 1.05);
  ASSERT_EQ(Run("export room.json --format visma --out visma"), 0) << Output();
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "visma/CAD/chair_x1.0500.obj"));
  Write("move.json", R"([{"edit": "change", "id": "chair_1", "scale": 1.02}])");
  ASSERT_EQ(Run("apply room.json move.json --annotator Grace"), 0) << Output();
  EXPECT_EQ(Json("room.json")["state"]["stage"], "in work") << "it was done";
  EXPECT_EQ(Json("room.json")["state"]["annotator"], "Grace");
}

}  // namespace
}  // namespace plumbline
