// SPDX-License-Identifier: Apache-2.0
// Nothing is lost in the window: kills, full disks, second windows; and what it writes on request.

#include <chrono>
#include <thread>

#include "engine/annotation/annotation_project.h"
#include "engine/geometry/gravity.h"
#include "engine/models/mesh_file.h"
#include "tests/ui/annotate_window_fixture.h"

namespace plumbline {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// For a shell: the one process that the process of this line has started.
std::string ChildOf(const std::string& line) {
  const std::string parent = line.substr(0, line.find('\n'));
  return "$(cat /proc/" + parent + "/task/" + parent + "/children)";
}

TEST_F(AnnotateWindow, SavesAsItIsQuitSoThatNothingIsRecoveredAndUndoGoesOn) {
  ASSERT_EQ(Run(std::string(kFloor) + R"({"dump_state": "before.json"},
      {"key": "q", "control": true}, {"wait_frames": 2})"),
            0)
      << Errors();
  EXPECT_EQ(State("before.json")["modified"], true);
  ASSERT_EQ(Run(R"(
      {"dump_state": "again.json"},
      {"key": "z", "control": true},
      {"wait_for": {"annotate.floor_known": false, "annotate.redo": "Set gravity"}},
      {"key": "y", "control": true},
      {"wait_for": {"annotate.floor_known": true}})"),
            0)
      << Errors();
  EXPECT_EQ(State("again.json")["notices"], json::array());
  EXPECT_EQ(State("again.json")["recovered"], 0);
  EXPECT_EQ(State("again.json")["modified"], false);
  EXPECT_EQ(State("again.json")["undo"], "Set gravity");
}

TEST_F(AnnotateWindow, SavesAsItIsAskedToEndByASignal) {
  std::thread window([&] {
    EXPECT_EQ(
        Run(std::string(kFloor) + R"({"dump_state": "before.json"}, {"wait_for": {"never": true}})",
            "scan.ply", true, "", "echo $$ > pid; exec"),
        0)
        << Errors();
  });
  for (int i = 0; i < 600 && !std::filesystem::exists(File("before.json")); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(std::system(("kill -TERM " + ChildOf(ReadFile(File("pid")).value())).c_str()), 0);
  window.join();
  const auto project =
      AnnotationProject::Open(File("scan.annotation.json"), AnnotationProject::Access::kRead);
  ASSERT_TRUE(project.ok()) << project.error().message;
  EXPECT_EQ((*project)->num_recovered(), 0u);
  EXPECT_TRUE((*project)->document().floor_in_scan.has_value());
}

TEST_F(AnnotateWindow, SaysWhatIsWrongWithAScan) {
  std::ofstream(File("broken.ply")) << "ply\nformat nonsense\n";
  ASSERT_EQ(Run(R"({"wait_for": {"annotate.state": "ready", "annotate.busy": ""}},
      {"wait_frames": 10}, {"dump_state": "broken.json"})",
                "broken.ply", false),
            0)
      << Errors();
  ASSERT_FALSE(State("broken.json")["notices"].empty());
  EXPECT_THAT(State("broken.json")["notices"][0].get<std::string>(), HasSubstr("broken.ply"));
}

TEST_F(AnnotateWindow, OffersWhatAKilledWindowHadDoneAndKeepsItOrTakesItBack) {
  // Placed and not saved; then killed in the middle of its work.
  const std::string kill = R"({"dump_state": "placed.json"}, {"wait_for": {"never": true}})";
  std::thread window([&] {
    Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1}},
      {"wait_frames": 2},)" +
            kill,
        "scan.ply", true, "", "echo $$ > pid; exec");
  });
  for (int i = 0; i < 600 && !std::filesystem::exists(File("placed.json")); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  // `timeout` is what was started: its child, the window, is the one to die by force.
  EXPECT_EQ(std::system(("kill -9 " + ChildOf(ReadFile(File("pid")).value())).c_str()), 0);
  window.join();
  ASSERT_TRUE(std::filesystem::exists(File("placed.json"))) << Errors();
  ASSERT_EQ(Run(R"(
      {"wait_for": {"annotate.recovered": 2}},
      {"dump_state": "offered.json"},
      {"screenshot": "offered.png"},
      {"click": "annotate.recover_drop"},
      {"wait_for": {"annotate.instances": 0, "annotate.recovered": 0}},
      {"key": "y", "control": true, "times": 2},
      {"wait_for": {"annotate.instances": 1}})"),
            0)
      << Errors();
  EXPECT_THAT(State("offered.json")["notices"][0].get<std::string>(),
              HasSubstr("2 edits recovered"));
  EXPECT_EQ(State("offered.json")["instances"], State("placed.json")["instances"]);
  {
    // As a process leaves it that ends without saving.
    auto project = AnnotationProject::Open(File("scan.annotation.json"));
    ASSERT_TRUE(project.ok()) << project.error().message;
    EXPECT_EQ((*project)->num_recovered(), 0u) << "saved as the window was closed";
    ChangeInstance change;
    change.id = "armchair_0";
    change.set.note = "mine";
    ASSERT_TRUE((*project)->Apply(change).ok());
  }
  ASSERT_EQ(Run(R"(
      {"wait_for": {"annotate.recovered": 1}},
      {"screenshot": "kept.png"},
      {"click": "annotate.recover_save"},
      {"wait_for": {"annotate.modified": false, "annotate.recovered": 0}},
      {"wait_frames": 3},
      {"dump_state": "saved.json"})"),
            0)
      << Errors();
  EXPECT_EQ(State("saved.json")["notices"], json::array());
  ASSERT_EQ(State("saved.json")["instances"].size(), 1u);
  EXPECT_EQ(State("saved.json")["instances"][0]["note"], "mine");
}

TEST_F(AnnotateWindow, OnAFullDiskItShowsABannerGoesOnAndSavesElsewhere) {
  if (std::system("unshare -rm true 2>/dev/null") != 0) {
    GTEST_SKIP() << "no small file system can be mounted here";
  }
  // Room for the project, its lock and the first page of its journal.
  std::filesystem::create_directories(folder_.path() / "small");
  const std::string mount =
      "mount -t tmpfs -o size=12k none small && ln -s ../scan.ply ../models small && ";
  const int status = Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1}},
      {"key": "escape"},
      {"key": "d", "times": 30},
      {"wait_for": {"annotate.unsafe": true}},
      {"wait_frames": 5},
      {"dump_state": "full.json"},
      {"screenshot": "full.png"},
      {"key": "d"},
      {"wait_frames": 5},
      {"key": "q", "control": true},
      {"wait_frames": 5},
      {"screenshot": "stays.png"},
      {"drop": ["scan.ply"]},
      {"wait_frames": 5},
      {"dump_state": "not_opened.json"},
      {"click": "annotate.elsewhere"},
      {"text": "rescued.json"},
      {"click": "annotate.save_elsewhere"},
      {"wait_for": {"annotate.unsafe": false, "annotate.modified": false}},
      {"wait_frames": 3},
      {"dump_state": "rescued_state.json"})",
                         "small/scan.ply", true, "\"", "unshare -rm sh -c \"" + mount);
  ASSERT_EQ(status, 0) << Errors();
  EXPECT_THAT(State("full.json")["journal_problem"].get<std::string>(), HasSubstr("No space"));
  EXPECT_EQ(State("not_opened.json")["project"], State("full.json")["project"])
      << "what would be lost is asked about, also by opening another scan";
  EXPECT_EQ(State("rescued_state.json")["project"], "rescued.json");
  const auto rescued =
      AnnotationProject::Open(File("rescued.json"), AnnotationProject::Access::kRead);
  ASSERT_TRUE(rescued.ok()) << rescued.error().message;
  ASSERT_EQ((*rescued)->document().instances.size(), 1u);
  EXPECT_THAT((*rescued)->document().instances[0].scan_from_object,
              IsometryNear(PoseOf(State("rescued_state.json")["instances"][0]), 1e-6, 1e-9));
}

TEST_F(AnnotateWindow, ASecondWindowIsToldWhoHasTheProjectAndReadsOnly) {
  auto first = AnnotationProject::Create(File("scan.annotation.json"), [&] {
    AnnotationDocument document;
    document.scan = "scan.ply";
    document.models = "models";
    return document;
  }());
  ASSERT_TRUE(first.ok()) << first.error().message;
  ASSERT_EQ(Run(R"(
      {"dump_state": "second.json"},
      {"screenshot": "second.png"},
      {"click": "annotate.dismiss"},
      {"click": "project.more"},
      {"wait_frames": 3},
      {"click": "more.save_as.field"},
      {"key": "a", "control": true},
      {"text": "mine.json"},
      {"key": "enter"},
      {"wait_for": {"annotate.read_only": false}})"),
            0)
      << Errors();
  const json second = State("second.json");
  EXPECT_EQ(second["read_only"], true);
  EXPECT_THAT(second["notices"][0].get<std::string>(),
              HasSubstr("open in another window or command (process"));
  EXPECT_TRUE(std::filesystem::exists(File("mine.json")));
}

TEST_F(AnnotateWindow, CutsByAnUprightBoxWhoseSidesAreDragged) {
  ASSERT_EQ(Run(std::string(kFloor) + R"(
      {"click": "annotate.tool.cut"},
      {"wait_for": {"annotate.tool": "cut"}},
      {"click": "annotate.view", "at": [0.59, 0.43]},
      {"wait_for": {"annotate.box": true}},
      {"wait_frames": 10},
      {"dump_state": "put.json"},
      {"drag": "crop.handle.left", "from": [0.5, 0.5], "to": [-4, 0.5]},
      {"wait_frames": 5},
      {"dump_state": "narrower.json"},
      {"drag": "crop.handle.middle", "from": [0.5, 0.5], "to": [0.5, -1.5]},
      {"wait_frames": 5},
      {"dump_state": "moved.json"},
      {"drag": "crop.handle.ring", "from": [0.5, 0.5], "to": [0.5, -4]},
      {"wait_frames": 5},
      {"dump_state": "turned.json"},
      {"screenshot": "box.png"},
      {"click": "crop.azimuth"},
      {"text": "50"},
      {"key": "enter"},
      {"wait_frames": 5},
      {"click": "crop.shrink"},
      {"wait_frames": 5},
      {"click": "crop.fragment"},
      {"click": "crop.name"},
      {"key": "end"},
      {"text": "_0"},
      {"click": "crop.cut"},
      {"wait_for": {"annotate.proposal": "crop", "annotate.running": false}},
      {"wait_frames": 3},
      {"dump_state": "cut.json"},
      {"screenshot": "cut.png"},
      {"key": "enter"},
      {"wait_for": {"annotate.proposal": "", "annotate.undo": "Cut out cutout_0"}},
      {"key": "z", "control": true},
      {"wait_for": {"annotate.undo": "Set gravity"}})"),
            0)
      << Errors();
  const json put = State("put.json"), narrower = State("narrower.json"),
             moved = State("moved.json"), turned = State("turned.json");
  EXPECT_GT(put["box_points"], 3000);
  const json &fitted = put["crop_box"]["size_m"], &dragged = narrower["crop_box"]["size_m"];
  EXPECT_LT(fitted[0].get<double>() + fitted[1].get<double>(), 1.8) << "it fits the armchair";
  EXPECT_LT(dragged[1], fitted[1].get<double>() - 0.05);
  EXPECT_EQ(dragged[0], fitted[0]);
  EXPECT_LT(narrower["box_points"], put["box_points"].get<int>()) << "live";
  EXPECT_GT(moved["crop_box"]["center"][1], narrower["crop_box"]["center"][1].get<double>() + 0.02);
  EXPECT_EQ(moved["crop_box"]["center"][2], put["crop_box"]["center"][2]) << "along the floor";
  EXPECT_GT(std::abs(WrapAngle(turned["crop_box"]["azimuth_rad"].get<double>() -
                               moved["crop_box"]["azimuth_rad"].get<double>())),
            0.05);
  EXPECT_EQ(State("cut.json")["crop"]["problem"], "");
}

TEST_F(AnnotateWindow, ExportsFromTheSheetAndRefusesInOneSentence) {
  ASSERT_EQ(Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1}},
      {"key": "escape"},
      {"click": "project.export"},
      {"wait_frames": 3},
      {"click": "export.frame.level"},
      {"click": "export.write"},
      {"wait_for": {"annotate.exported": "done"}},
      {"wait_frames": 3},
      {"screenshot": "export.png"},
      {"click": "export.browse"},
      {"wait_for": {"path_dialog": true}},
      {"wait_frames": 12},
      {"text": "elsewhere"},
      {"wait_frames": 3},
      {"key": "enter"},
      {"wait_for": {"path_dialog": false}},
      {"wait_frames": 5},
      {"click": "export.write"},
      {"wait_for": {"annotate.exported": "done"}},
      {"wait_frames": 3},
      {"click": "export.browse"},
      {"wait_for": {"path_dialog": true}},
      {"wait_frames": 12},
      {"key": "escape"},
      {"wait_frames": 8},
      {"click": "export.visma"},
      {"wait_frames": 2},
      {"click": "export.write"},
      {"wait_for": {"annotate.exported": "done"}},
      {"click": "export.poses"},
      {"wait_frames": 2},
      {"click": "export.write"},
      {"wait_frames": 30},
      {"dump_state": "refused.json"},
      {"screenshot": "refused.png"})"),
            0)
      << Errors();
  EXPECT_TRUE(std::filesystem::exists(File("ground_truth.json")));
  EXPECT_TRUE(std::filesystem::exists(File("elsewhere.json"))) << "chosen from the list";
  EXPECT_TRUE(std::filesystem::exists(File("visma/fragments/alignment.json")));
  EXPECT_THAT(State("refused.json")["exported"].get<std::string>(), HasSubstr("needs a sequence"));
}

TEST_F(AnnotateWindow, AnExportAsksBeforeItReplacesWhatIsThereAndKeepsIt) {
  std::ofstream(File("ground_truth.json")) << R"({"gravity": [0, 0, -1], "instances": [
      {"id": "sofa_0", "model": "sofa", "category": "couch", "quality": "fine",
       "world_from_object": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]})";
  const std::string before = ReadFile(File("ground_truth.json")).value();
  ASSERT_EQ(Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1}},
      {"key": "escape"},
      {"key": "e", "control": true},
      {"wait_frames": 3},
      {"click": "export.write"},
      {"wait_for": {"annotate.exported": "asks"}},
      {"wait_frames": 3},
      {"dump_state": "asks.json"},
      {"screenshot": "asks.png"},
      {"click": "export.replace"},
      {"wait_for": {"annotate.exported": "done"}},
      {"wait_frames": 3},
      {"screenshot": "replaced.png"})"),
            0)
      << Errors();
  const json differences = State("asks.json")["differences"];
  ASSERT_EQ(differences.size(), 2u);
  EXPECT_EQ(differences[0], "1 object would be gone: sofa_0.");
  EXPECT_EQ(differences[1], "1 object would be new: armchair_0.");
  EXPECT_EQ(ReadFile(File("ground_truth.json.bak")).value(), before);
  EXPECT_NE(ReadFile(File("ground_truth.json")).value(), before);
}

TEST_F(AnnotateWindow, AScanInMillimetresIsToldAndCopied) {
  ASSERT_TRUE(WritePly(scene_.scan, Scaled(ReadMesh(scene_.scan).value(), 1000)).ok());
  ASSERT_EQ(Run(R"(
      {"wait_for": {"annotate.doubted_size_m": {"min": 1000}}},
      {"wait_frames": 3},
      {"screenshot": "unit.png"},
      {"click": "annotate.unit.mm"},
      {"wait_for": {"annotate.doubted_size_m": 0, "annotate.aligns": true, "annotate.busy": "",
                    "annotate.undo": "Take the scan in metres"}},
      {"wait_frames": 3},
      {"screenshot": "metres.png"})"),
            0)
      << Errors();
  EXPECT_TRUE(std::filesystem::exists(File("scan-metres.ply")));
}

}  // namespace
}  // namespace plumbline
