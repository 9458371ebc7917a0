// SPDX-License-Identifier: Apache-2.0
// Drives the real window's Annotate workspace on a private display, through scripts.

#include <numbers>

#include <opencv2/imgcodecs.hpp>

#include "engine/session/sequence_registration.h"
#include "tests/ui/annotate_window_fixture.h"

namespace plumbline {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST_F(AnnotateWindow, PlacesAModelByClicksNudgesUndoesSavesAndOpensItAgain) {
  ASSERT_EQ(Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"wait_frames": 3},
      {"key": "down"},
      {"key": "up"},
      {"wait_for": {"annotate.candidate": 0}},
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1, "annotate.selected": "armchair_0"}},
      {"key": "escape"},
      {"wait_for": {"annotate.tool": "select"}},
      {"dump_state": "placed.json"},
      {"key": "d", "shift": true},
      {"wait_for": {"annotate.undo": "Move armchair_0"}},
      {"key": "z", "times": 2},
      {"wait_frames": 10},
      {"dump_state": "nudged.json"},
      {"key": "z", "control": true, "times": 3},
      {"wait_for": {"annotate.undo": "Add armchair_0"}},
      {"dump_state": "undone.json"},
      {"key": "y", "control": true, "times": 3},
      {"wait_for": {"annotate.redo": ""}},
      {"dump_state": "redone.json"},
      {"key": "s", "control": true},
      {"wait_for": {"annotate.modified": false}},
      {"dump_state": "saved.json"})"),
            0)
      << Errors();
  const Eigen::Isometry3d placed = PoseOf(State("placed.json")["instances"][0]);
  EXPECT_THAT(placed, IsometryNear(scene_.scan_from_armchair, 0.2, 0.002));
  // From above, right is +x: 5 cm, then half a degree twice.
  Eigen::Isometry3d expected = placed;
  expected.translation().x() += 0.05;
  expected.linear() =
      Eigen::AngleAxisd(std::numbers::pi / 180, Eigen::Vector3d::UnitZ()) * expected.linear();
  EXPECT_THAT(PoseOf(State("nudged.json")["instances"][0]), IsometryNear(expected, 0.001, 1e-4));
  EXPECT_EQ(State("undone.json")["instances"], State("placed.json")["instances"]);
  EXPECT_EQ(State("redone.json")["instances"], State("nudged.json")["instances"]);
  ASSERT_EQ(Run(R"({"dump_state": "again.json"})", "scan.annotation.json"), 0) << Errors();
  EXPECT_EQ(State("again.json")["instances"], State("saved.json")["instances"]);
  EXPECT_EQ(State("again.json")["level_from_scan"], State("saved.json")["level_from_scan"]);
  EXPECT_EQ(State("again.json")["notices"], json::array());
}

TEST_F(AnnotateWindow, MovesTurnsAndLiftsByTheGizmoOneUndoStepADrag) {
  ASSERT_EQ(Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1}},
      {"key": "escape"},
      {"key": "f"},
      {"wait_frames": 3},
      {"dump_state": "0.json"},
      {"drag": "annotate.view", "from": [0.5, 0.5], "to": [0.6, 0.5]},
      {"wait_for": {"annotate.undo": "Move armchair_0"}},
      {"wait_frames": 5},
      {"dump_state": "1.json"},
      {"key": "z", "control": true},
      {"wait_for": {"annotate.undo": "Add armchair_0"}},
      {"wait_frames": 3},
      {"dump_state": "2.json"})"),
            0)
      << Errors();
  const Eigen::Isometry3d before = PoseOf(State("0.json")["instances"][0]);
  const Eigen::Isometry3d after = PoseOf(State("1.json")["instances"][0]);
  EXPECT_GT(after.translation().x(), before.translation().x() + 0.05);
  EXPECT_NEAR(after.translation().y(), before.translation().y(), 0.02);
  EXPECT_NEAR(after.translation().z(), before.translation().z(), 1e-12) << "along the floor";
  EXPECT_THAT(after.linear().isApprox(before.linear(), 1e-12), true);
  EXPECT_EQ(State("2.json")["instances"], State("0.json")["instances"]);
}

TEST_F(AnnotateWindow, RefinesAndTakesTypedNumbersAndNotes) {
  ASSERT_EQ(Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1}},
      {"key": "escape"},
      {"wait_frames": 2},
      {"dump_state": "0.json"},
      {"double_click": "instance.azimuth"},
      {"text": "55"},
      {"key": "enter"},
      {"wait_for": {"annotate.undo": "Move armchair_0"}},
      {"wait_frames": 3},
      {"dump_state": "1.json"},
      {"click": "instance.refine"},
      {"wait_for": {"annotate.proposal": "refinement", "annotate.running": false}},
      {"wait_frames": 3},
      {"screenshot": "refined.png"},
      {"click": "proposal.accept"},
      {"wait_for": {"annotate.proposal": ""}},
      {"wait_frames": 3},
      {"dump_state": "2.json"},
      {"click": "instance.note"},
      {"text": "a leg is hidden"},
      {"key": "enter"},
      {"wait_frames": 5},
      {"click": "instance.coarse"},
      {"wait_frames": 5},
      {"click": "annotate_instances.lock.armchair_0"},
      {"wait_frames": 5},
      {"dump_state": "3.json"},
      {"key": "delete"},
      {"wait_frames": 5},
      {"dump_state": "4.json"})"),
            0)
      << Errors();
  const auto azimuth = [&](const char* file) {
    const Eigen::Matrix3d r = PoseOf(State(file)["instances"][0]).linear();
    return std::atan2(r(1, 0), r(0, 0)) * 180 / std::numbers::pi;
  };
  EXPECT_NEAR(azimuth("1.json"), 55, 0.02);
  EXPECT_THAT(PoseOf(State("2.json")["instances"][0]),
              IsometryNear(scene_.scan_from_armchair, 0.2, 0.002));
  const json instance = State("3.json")["instances"][0];
  EXPECT_EQ(instance["note"], "a leg is hidden");
  EXPECT_EQ(instance["quality"], "coarse");
  EXPECT_EQ(instance["locked"], true);
  EXPECT_EQ(State("4.json")["instances"].size(), 1u) << "a locked object stays";
}

TEST_F(AnnotateWindow, SnapsCopiesDuplicatesRenamesHidesLocksAndSearches) {
  ASSERT_EQ(Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1}},
      {"key": "escape"},
      {"key": "e", "times": 4},
      {"wait_for": {"annotate.undo": "Move armchair_0"}},
      {"wait_frames": 15},
      {"dump_state": "lifted.json"},
      {"key": "g"},
      {"wait_frames": 10},
      {"dump_state": "snapped.json"},
      {"key": "c", "control": true},
      {"key": "d", "control": true},
      {"wait_for": {"annotate.instances": 2, "annotate.selected": "armchair_1"}},
      {"wait_frames": 3},
      {"dump_state": "copy.json"},
      {"key": "v", "control": true, "shift": true},
      {"wait_for": {"annotate.undo": "Move armchair_1"}},
      {"wait_frames": 5},
      {"dump_state": "pasted.json"},
      {"click": "instance.name"},
      {"text": "beside"},
      {"key": "enter"},
      {"wait_for": {"annotate.selected": "beside"}},
      {"key": "h"},
      {"wait_frames": 10},
      {"dump_state": "hidden.json"},
      {"key": "h"},
      {"key": "l"},
      {"wait_frames": 10},
      {"key": "d"},
      {"wait_frames": 10},
      {"dump_state": "locked.json"},
      {"click": "annotate_models.filter"},
      {"text": "tab"},
      {"wait_frames": 3},
      {"dump_state": "found.json"})"),
            0)
      << Errors();
  const auto pose = [&](const char* file, int index) {
    return PoseOf(State(file)["instances"][index]);
  };
  EXPECT_NEAR(pose("lifted.json", 0).translation().z(), 0.02, 1e-9);
  EXPECT_NEAR(pose("snapped.json", 0).translation().z(), 0, 1e-12);
  EXPECT_GT((pose("copy.json", 1).translation() - pose("copy.json", 0).translation()).norm(), 0.3);
  EXPECT_EQ(pose("pasted.json", 1).matrix(), pose("pasted.json", 0).matrix());
  EXPECT_EQ(State("hidden.json")["instances"][1]["id"], "beside");
  EXPECT_EQ(State("hidden.json")["instances"][1]["hidden"], true);
  EXPECT_EQ(State("locked.json")["instances"][1]["hidden"], false);
  EXPECT_EQ(State("locked.json")["instances"][1]["locked"], true);
  EXPECT_EQ(pose("locked.json", 1).matrix(), pose("pasted.json", 1).matrix());
  const json widgets = ReadJson(File("found.json")).value()["widgets"];
  EXPECT_TRUE(widgets.contains("annotate_models.table"));
  EXPECT_FALSE(widgets.contains("annotate_models.armchair"));
}

TEST_F(AnnotateWindow, AFolderOfScansIsDoneOneAfterTheOther) {
  std::filesystem::copy_file(scene_.scan, folder_.path() / "attic.ply");
  ASSERT_EQ(Run(R"(
      {"wait_for": {"annotate.queue": 2, "annotate.aligns": true, "annotate.busy": ""}},
      {"wait_frames": 5},
      {"dump_state": "first.json"},
      {"click": "queue.row.scan.ply", "at": [0.1, 0.5]},
      {"wait_frames": 5},
      {"wait_for": {"annotate.queue": 2, "annotate.aligns": true, "annotate.busy": "",
                    "annotate.stage": "new"}},
      {"key": "o", "control": true, "shift": true},
      {"wait_frames": 5},
      {"click": "queue.hand_over"},
      {"wait_for": {"annotate.stage": "to review"}},
      {"key": "escape"},
      {"wait_frames": 3},
      {"dump_state": "second.json"},
      {"key": "z", "control": true},
      {"wait_for": {"annotate.stage": "new"}})",
                ".", false, "--annotator Ada"),
            0)
      << Errors();
  EXPECT_EQ(State("first.json")["project"], "attic.annotation.json");
  EXPECT_EQ(State("second.json")["project"], "scan.annotation.json");
  EXPECT_EQ(State("second.json")["undo"], "Hand it over for review");
}

TEST_F(AnnotateWindow, CountsTheTimeThatSomebodyWorksOnAnObject) {
  ASSERT_EQ(Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1}},
      {"key": "escape"},
      {"wait_frames": 3},
      {"dump_state": "placed.json"},
      {"key": "f", "times": 150},
      {"wait_frames": 8},
      {"dump_state": "looked.json"})"),
            0)
      << Errors();
  const auto spent = [&](const char* file) {
    return State(file)["seconds_spent"]["armchair_0"].get<double>();
  };
  EXPECT_GT(spent("looked.json"), spent("placed.json") + 1) << "the view alone was turned";
}

TEST_F(AnnotateWindow, ShowsTheOutlineInImagesWhileItMovesAndRefinesByThem) {
  WriteAnnotationWalk(scene_, folder_.path() / "walk");
  ASSERT_EQ(Run(std::string(kFloor) + kPlaceArmchair + R"(
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1}},
      {"key": "escape"},
      {"wait_for": {"annotate.images": {"min": 6}, "annotate.busy": ""}},
      {"wait_frames": 3},
      {"dump_state": "placed.json"},
      {"key": "f"},
      {"wait_frames": 3},
      {"drag": "annotate.view", "from": [0.5, 0.5], "to": [0.53, 0.5]},
      {"wait_for": {"annotate.undo": "Move armchair_0"}},
      {"wait_for": {"annotate.agreement_percent": {"max": 50}}},
      {"wait_for": {"annotate.busy": ""}},
      {"dump_state": "dragged.json"},
      {"screenshot": "dragged.png"},
      {"click": "images.2"},
      {"wait_frames": 5},
      {"dump_state": "there.json"},
      {"click": "instance.by_images"},
      {"wait_for": {"annotate.proposal": "refinement", "annotate.running": false}, "timeout_s": 60},
      {"wait_frames": 3},
      {"dump_state": "refined.json"},
      {"key": "escape"},
      {"wait_for": {"annotate.proposal": "", "annotate.agreement_percent": {"max": 50}}},
      {"dump_state": "rejected.json"},
      {"click": "instance.by_images"},
      {"wait_for": {"annotate.proposal": "refinement", "annotate.running": false}, "timeout_s": 60},
      {"key": "enter"},
      {"wait_for": {"annotate.proposal": ""}},
      {"wait_frames": 3},
      {"dump_state": "taken.json"})",
                "scan.ply", true, "--sequence walk"),
            0)
      << Errors();
  EXPECT_GT(State("placed.json")["agreement"], 0.8);
  EXPECT_EQ(State("rejected.json")["instances"], State("dragged.json")["instances"]);
  const json refined = State("refined.json")["refinement"];
  EXPECT_GT(refined["agreement"], 0.8);
  EXPECT_GT(refined["horizontal_std_m"], 0);
  EXPECT_LT(refined["horizontal_std_m"], 0.02) << "the cameras may all be off by 1 cm per axis";
  EXPECT_THAT(PoseOf(State("taken.json")["instances"][0]),
              IsometryNear(scene_.scan_from_armchair, 0.3, 0.004));
  // Looking from where frame 2 of the strip was taken: the eye is there.
  const json eye = State("there.json")["eye_in_level"], camera = State("there.json")["images"][2];
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(eye[i], camera["eye_in_level"][i], 1e-3);
}

TEST_F(AnnotateWindow, RegistersASequenceByPointsClickedInTheScanAndInItsFrames) {
  const Eigen::Isometry3d world_from_scan =
      Eigen::Translation3d(1, -2, 0.4) * Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ());
  WriteAnnotationWalk(scene_, folder_.path() / "walk", world_from_scan);
  struct Click {
    double x, y;  // where the scan is clicked
    int frame;
  };
  constexpr Click kClicks[] = {
      {0.56, 0.36, 5}, {0.62, 0.36, 5}, {0.62, 0.52, 11}, {0.55, 0.52, 19}};
  // First with any pixel, to learn which points the clicks meet; then with the right ones.
  const auto steps = [&](const std::vector<Eigen::Vector2d>& at) {
    std::string text = std::string(kFloor) + R"({"click": "annotate.tool.sequence"},
        {"wait_for": {"annotate.tool": "sequence", "annotate.frame": 12}},)";
    for (std::size_t i = 0; i < std::size(kClicks); ++i) {
      const auto at_scan = json{kClicks[i].x, kClicks[i].y}, at_frame = json{at[i].x(), at[i].y()};
      text += R"({"click": "frame.number", "at": [)" +
              std::to_string((kClicks[i].frame + 0.5) / 24) +
              R"(, 0.5]}, {"wait_for": {"annotate.frame": )" + std::to_string(kClicks[i].frame) +
              R"(}}, {"click": "annotate.view", "at": )" + at_scan.dump() +
              R"(}, {"wait_frames": 2}, {"click": "frame.view", "at": )" + at_frame.dump() +
              R"(}, {"wait_for": {"annotate.pairs": )" + std::to_string(i + 1) + "}},";
    }
    return text;
  };
  const std::vector<Eigen::Vector2d> middles(std::size(kClicks), Eigen::Vector2d(0.5, 0.5));
  ASSERT_EQ(
      Run(steps(middles) + R"({"dump_state": "met.json"})", "scan.ply", true, "--sequence walk"), 0)
      << Errors();
  for (const char* ending : {"", ".journal"}) {
    std::filesystem::remove(File(std::string("scan.annotation.json") + ending));
  }
  const auto sequence = OpenSequence(folder_.path() / "walk").value();
  std::vector<Eigen::Vector2d> right;
  for (std::size_t i = 0; i < std::size(kClicks); ++i) {
    const json in_scan = State("met.json")["pairs"][i]["in_scan"];
    const auto pixel = SeenAt(*sequence, kClicks[i].frame, world_from_scan.inverse(),
                              Eigen::Vector3d(in_scan[0].get<double>(), in_scan[1].get<double>(),
                                              in_scan[2].get<double>()));
    ASSERT_TRUE(pixel.has_value());
    const PinholeCamera& camera = sequence->camera();
    right.emplace_back((pixel->x() + 0.5) / camera.width, (pixel->y() + 0.5) / camera.height);
  }
  ASSERT_EQ(Run(steps(right) + R"(
      {"click": "sequence.by_pairs"},
      {"wait_for": {"annotate.proposal": "sequence", "annotate.running": false}},
      {"wait_frames": 3},
      {"dump_state": "proposed.json"},
      {"screenshot": "sequence.png"},
      {"key": "enter"},
      {"wait_for": {"annotate.registered": true, "annotate.tool": "select"}},
      {"key": "z", "control": true},
      {"wait_for": {"annotate.registered": false}},
      {"key": "y", "control": true},
      {"wait_for": {"annotate.registered": true}},
      {"key": "s", "control": true},
      {"wait_for": {"annotate.modified": false}})",
                "scan.ply", true, "--sequence walk"),
            0)
      << Errors();
  const json found = State("proposed.json")["sequence"];
  EXPECT_EQ(found["problem"], "");
  // A click is as good as the window's pixels are small: 4 image pixels, at 2 m.
  EXPECT_THAT(PoseOf(json{{"scan_from_object", found["scan_from_world"]}}),
              IsometryNear(world_from_scan.inverse(), 0.5, 0.03));
  for (const json& pair : State("proposed.json")["pairs"]) EXPECT_LT(pair["residual_px"], 4);
}

TEST_F(AnnotateWindow, TakesDraftsOfARunMendsOneAcceptsItAndUndoesThemAsOne) {
  // The armchair a little off, the table of a model that the database does not have.
  const Eigen::Isometry3d off = scene_.scan_from_armchair * Eigen::Translation3d(0.05, 0.03, 0);
  json rows;
  for (int row = 0; row < 4; ++row) {
    rows.push_back(
        {off.matrix()(row, 0), off.matrix()(row, 1), off.matrix()(row, 2), off.matrix()(row, 3)});
  }
  const json identity = {{1, 0, 0, -1}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  std::ofstream(File("run.json")) << json{{"objects",
                                           {{{"id", 1},
                                             {"model", "armchair"},
                                             {"category", "chair"},
                                             {"confirmed", true},
                                             {"world_from_object", rows}},
                                            {{"id", 2},
                                             {"model", "desk"},
                                             {"category", "dining table"},
                                             {"confirmed", true},
                                             {"world_from_object", identity}}}}};
  ASSERT_EQ(Run(std::string(kFloor) + R"(
      {"click": "project.more"},
      {"wait_frames": 3},
      {"click": "more.drafts.field"},
      {"text": "run.json"},
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 2, "annotate.undo": "Take drafts from run.json"}},
      {"wait_frames": 3},
      {"dump_state": "drafts.json"},
      {"screenshot": "drafts.png"},
      {"click": "annotate_instances.row.armchair_0"},
      {"wait_for": {"annotate.selected": "armchair_0"}},
      {"click": "instance.refine"},
      {"wait_for": {"annotate.proposal": "refinement", "annotate.running": false}},
      {"key": "enter"},
      {"wait_for": {"annotate.proposal": ""}},
      {"click": "instance.fine"},
      {"wait_frames": 5},
      {"dump_state": "accepted.json"},
      {"click": "annotate_instances.row.desk_0"},
      {"wait_for": {"annotate.selected": "desk_0"}},
      {"key": "delete"},
      {"wait_for": {"annotate.instances": 1}},
      {"key": "z", "control": true, "times": 4},
      {"wait_for": {"annotate.instances": 0}},
      {"key": "y", "control": true},
      {"wait_for": {"annotate.instances": 2}})"),
            0)
      << Errors();
  const json draft = State("drafts.json")["instances"][0];
  EXPECT_EQ(draft["quality"], "coarse");
  EXPECT_THAT(draft["note"].get<std::string>(), HasSubstr("draft: object 1 of run.json"));
  EXPECT_THAT(PoseOf(draft), IsometryNear(off, 1e-6, 1e-9));
  const json mended = State("accepted.json")["instances"][0];
  EXPECT_EQ(mended["quality"], "fine");
  EXPECT_THAT(PoseOf(mended), IsometryNear(scene_.scan_from_armchair, 0.2, 0.003));
}

TEST_F(AnnotateWindow, CutsAFragmentOutByALineAndSaysWhatCannotBeCut) {
  ASSERT_EQ(Run(std::string(kFloor) + R"(
      {"click": "annotate.tool.cut"},
      {"wait_for": {"annotate.tool": "cut"}},
      {"wait_frames": 2},
      {"click": "crop.line"},
      {"drag": "annotate.view", "from": [0.52, 0.30], "to": [0.66, 0.55]},
      {"wait_for": {"annotate.proposal": "crop", "annotate.running": false}},
      {"wait_frames": 3},
      {"dump_state": "model.json"},
      {"click": "crop.fragment"},
      {"click": "crop.name"},
      {"key": "end"},
      {"text": "_0"},
      {"click": "crop.again"},
      {"wait_for": {"annotate.crop": "cutout_0", "annotate.running": false}},
      {"wait_frames": 3},
      {"dump_state": "box.json"},
      {"screenshot": "box.png"},
      {"click": "proposal.cancel"},
      {"wait_for": {"annotate.proposal": ""}},
      {"click": "annotate.view", "at": [0.52, 0.30]},
      {"click": "annotate.view", "at": [0.66, 0.30]},
      {"click": "annotate.view", "at": [0.66, 0.55]},
      {"click": "annotate.view", "at": [0.52, 0.55]},
      {"wait_frames": 2},
      {"key": "enter"},
      {"wait_for": {"annotate.proposal": "crop", "annotate.running": false}},
      {"wait_frames": 3},
      {"dump_state": "line.json"},
      {"key": "enter"},
      {"wait_for": {"annotate.proposal": "", "annotate.tool": "select"}},
      {"dump_state": "taken.json"},
      {"key": "z", "control": true},
      {"wait_for": {"annotate.undo": "Set gravity"}})"),
            0)
      << Errors();
  EXPECT_THAT(State("model.json")["crop"]["problem"].get<std::string>(), HasSubstr("fragment"))
      << "points have no surface";
  const json box = State("box.json")["crop"], line = State("line.json")["crop"];
  EXPECT_EQ(box["problem"], "");
  EXPECT_EQ(box["id"], "cutout_0");
  EXPECT_GT(box["points"], 3000);
  EXPECT_NEAR(line["points"], box["points"].get<double>(), 0.02 * box["points"].get<double>());
  EXPECT_NE(State("taken.json")["undo"], "Set gravity");
}

TEST_F(AnnotateWindow, FromTheFloorToTheCopyWithoutAMouse) {
  ASSERT_EQ(Run(R"(
      {"key": "p", "control": true},
      {"wait_for": {"palette": true}},
      {"wait_frames": 3},
      {"text": "find the floor"},
      {"key": "enter"},
      {"wait_for": {"annotate.proposal": "floor"}},
      {"key": "enter"},
      {"wait_for": {"annotate.floor_known": true}},
      {"key": "pad7"},
      {"wait_frames": 3},
      {"dump_state": "above.json"},
      {"key": "p", "control": true},
      {"wait_frames": 4},
      {"dump_state": "palette.json"},
      {"screenshot": "palette.png"},
      {"key": "escape"},
      {"wait_for": {"palette": false}},
      {"key": "m"},
      {"wait_for": {"palette": true}},
      {"wait_frames": 3},
      {"text": "armch"},
      {"wait_frames": 2},
      {"screenshot": "models.png"},
      {"key": "enter"},
      {"wait_for": {"annotate.tool": "place"}},
      {"key": "padenter"},
      {"wait_for": {"annotate.proposal": "placement", "annotate.running": false}},
      {"key": "enter"},
      {"wait_for": {"annotate.instances": 1, "annotate.selected": "armchair_0"}},
      {"key": "escape", "times": 2},
      {"wait_for": {"annotate.tool": "select", "annotate.selected": ""}},
      {"key": "tab"},
      {"wait_for": {"annotate.selected": "armchair_0"}},
      {"key": "d", "control": true},
      {"wait_for": {"annotate.selected": "armchair_1"}},
      {"key": "tab"},
      {"wait_for": {"annotate.selected": "armchair_0"}},
      {"key": "tab", "shift": true},
      {"wait_for": {"annotate.selected": "armchair_1"}},
      {"click": "annotate.view", "at": [0.05, 0.95], "button": "right"},
      {"wait_frames": 4},
      {"screenshot": "menu.png"},
      {"key": "escape"},
      {"wait_frames": 2},
      {"key": "delete"},
      {"wait_for": {"annotate.instances": 1}})"),
            0)
      << Errors();
  const json eye = State("above.json")["eye_in_level"];
  EXPECT_GT(eye[2].get<double>(), 2 * std::hypot(eye[0].get<double>(), eye[1].get<double>()));
}

TEST_F(AnnotateWindow, KeepsEveryControlInsideAndSwitchesToInspectAndBack) {
  for (const auto& [width, height] : {std::pair{1024, 700}, {1600, 1000}}) {
    ASSERT_EQ(Run(R"(
      {"resize": [)" +
                  std::to_string(width) + ", " + std::to_string(height) + R"(]},
      {"wait_frames": 3},
      {"screenshot": "window.png"},
      {"dump_state": "state.json"},
      {"click": "top.inspect"},
      {"wait_for": {"workspace": "inspect"}},
      {"click": "top.annotate"},
      {"wait_for": {"workspace": "annotate"}})"),
              0)
        << Errors();
    const auto state = ReadJson(File("state.json")).value();
    for (const auto& [name, rect] : state["widgets"].items()) {
      if (name.starts_with("annotate_models.")) continue;  // they scroll
      EXPECT_GE(rect[0], 0) << name;
      EXPECT_GE(rect[1], 0) << name;
      EXPECT_LE(rect[2], width) << name;
      EXPECT_LE(rect[3], height) << name;
    }
  }
}

}  // namespace
}  // namespace plumbline
