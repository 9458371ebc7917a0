// SPDX-License-Identifier: Apache-2.0
// Panels without a display: what they post, what they keep, and that no state of the world upsets
// them.

#include "engine/snapshot/frame_analysis.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/inspect/inspect_bar.h"
#include "ui/inspect/map/scene_overlay.h"
#include "ui/inspect/panel_table.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "tests/ui/panel_harness.h"

namespace plumbline {
namespace {

std::vector<std::unique_ptr<Panel>> AllPanels() {
  std::vector<std::unique_ptr<Panel>> panels;
  for (const PanelEntry& entry : InspectPanels()) panels.push_back(MakePanel(entry));
  return panels;
}

TEST(Panels, DrawInEveryStateOfTheWorld) {
  for (const auto& panel : AllPanels()) {
    PanelHarness harness;
    SCOPED_TRACE(panel->id());
    harness.Draw(*panel, 3);
    EXPECT_GT(harness.vertices, 0) << "before anything is open it says so";
    harness.ShowFrame(0);
    harness.Draw(*panel, 3);
    harness.context.selection.object = {3};
    harness.ShowFrame(0);  // not yet born
    harness.Draw(*panel, 3);
    harness.ShowFrame(30);
    harness.context.selection.particle = 4;
    harness.Draw(*panel, 3);
    harness.context.selection.object = {99};
    harness.Draw(*panel, 3);
    EXPECT_GT(harness.vertices, 0);
    const bool explains = std::string(panel->id()) == "why";  // asks to have scores explained
    for (const Command& command : harness.sink.commands) {
      const auto* inspect = std::get_if<InspectCommand>(&command);
      const bool needs = inspect != nullptr && std::holds_alternative<NeedCommand>(*inspect);
      EXPECT_TRUE(explains || needs) << "nobody asked for anything";
    }
  }
}

TEST(Panels, DrawFramesWithoutImagesPosesAndMaps) {
  for (const auto& panel : AllPanels()) {
    PanelHarness harness;
    SCOPED_TRACE(panel->id());
    harness.ShowFrame(20);
    auto bare = std::make_shared<MapSnapshot>();
    bare->report = harness.context.snapshot->report;
    bare->report.world_from_cam.reset();
    bare->report.skipped = "the image is missing";
    for (ObjectReport& object : bare->report.objects) {
      object.particles = nullptr;
      object.label = {77};  // no such model
      object.modes.clear();
      object.label_probability.clear();
    }
    harness.context.snapshot = bare;
    ++harness.context.snapshot_version;
    harness.context.selection.object = {1};
    harness.Draw(*panel, 3);
    EXPECT_GT(harness.vertices, 0);
  }
}

/// What is drawn has a place, and nothing is visible outside the panel.
void ExpectInside(const PanelHarness& harness) {
  const ImDrawData& data = *ImGui::GetDrawData();
  const float slack = 1;
  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    for (const ImDrawVert& vertex : list.VtxBuffer)
      ASSERT_TRUE(std::isfinite(vertex.pos.x) && std::isfinite(vertex.pos.y));
    if (std::string_view(list._OwnerName).find("test/") != 0) continue;  // the panel's own lists
    for (const ImDrawCmd& command : list.CmdBuffer) {
      if (command.ElemCount == 0) continue;
      EXPECT_GE(command.ClipRect.x, 20 - slack);
      EXPECT_GE(command.ClipRect.y, 20 - slack);
      EXPECT_LE(command.ClipRect.z, 20 + harness.size.x + slack);
      EXPECT_LE(command.ClipRect.w, 20 + harness.size.y + slack);
    }
  }
}

TEST(Panels, StayInsideAtAnySize) {
  for (const auto& panel : AllPanels()) {
    PanelHarness harness;
    harness.ShowFrame(30);
    harness.context.selection.object = {2};
    for (const ImVec2 size : {ImVec2(12, 12), ImVec2(90, 700), ImVec2(900, 60), ImVec2(60, 60)}) {
      SCOPED_TRACE(std::string(panel->id()) + " at " + std::to_string(size.x) + " x " +
                   std::to_string(size.y));
      harness.size = size;
      harness.Draw(*panel, 2);
      const WidgetLog::Rect* frame = harness.widgets.Find(std::string("panel.") + panel->id());
      ASSERT_NE(frame, nullptr);
      EXPECT_EQ(frame->high.x - frame->low.x, size.x);
      EXPECT_EQ(frame->high.y - frame->low.y, size.y);
      EXPECT_GT(harness.vertices, 0);
      ExpectInside(harness);
    }
  }
}

TEST(Panels, KeepTheirSwitches) {
  for (const auto& panel : AllPanels()) {
    const nlohmann::json before = panel->SaveState();
    nlohmann::json turned = before;
    for (auto& [key, value] : turned.items()) {
      if (value.is_boolean()) value = !value.get<bool>();
    }
    panel->LoadState(turned);
    EXPECT_EQ(panel->SaveState(), turned) << panel->id();
    panel->LoadState({{"of another version", 1}});
    EXPECT_EQ(panel->SaveState(), turned) << panel->id();
  }
}

TEST(Panels, MakePicturesOnlyForNewFrames) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("masks");
  harness.ShowFrame(10);
  harness.Draw(*panel, 5);
  EXPECT_EQ(harness.textures.pictures_made, 1);
  harness.ShowFrame(11);
  harness.Draw(*panel, 5);
  EXPECT_EQ(harness.textures.pictures_made, 2);
}

TEST(ImagePanel, SelectsTheObjectUnderTheMouse) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("image");
  harness.ShowFrame(20);
  const cv::Mat& id = harness.context.snapshot->id;
  cv::Point inside;
  for (int i = 0; i < static_cast<int>(id.total()); ++i) {
    if (id.ptr<std::uint16_t>()[i] == 2) inside = {i % id.cols, i / id.cols};
  }
  harness.Click(*panel, "image.view", (static_cast<float>(inside.x) + 0.5f) / 160,
                (static_cast<float>(inside.y) + 0.5f) / 90);
  ASSERT_NE(harness.sink.Last<SelectObjectCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>()->object, ObjectId{2});
  harness.Click(*panel, "image.view", 0.99f, 0.02f);
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>()->object, ObjectId{})
      << "the background clears";
}

TEST(ImagePanel, ZoomsAboutTheMouseAndMovesByDragging) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("image");
  harness.ShowFrame(20);
  harness.Wheel(*panel, "image.view", 4);
  EXPECT_GT(harness.viewport.zoom, 2);
  EXPECT_NEAR(harness.viewport.center.x, 0.5, 1e-3);
  harness.Drag(*panel, "image.view", {0.5f, 0.5f}, {0.6f, 0.5f}, 0);
  EXPECT_LT(harness.viewport.center.x, 0.5);
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>(), nullptr) << "a drag is no click";
}

TEST(ImagePanel, ShowsWhatTheDetectorScoresElsewhere) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("image");
  harness.ShowFrame(20);
  const auto& objects = harness.context.snapshot->report.objects;
  ASSERT_FALSE(objects.empty());
  harness.context.selection.object = objects[0].id;
  harness.Click(*panel, "image.scores");
  ASSERT_NE(harness.sink.Last<NeedCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<NeedCommand>()->what, NeedCommand::What::kScoreMap);
  const int before = harness.textures.pictures_made;
  harness.Analyse({}, {.score_map = true});
  harness.Draw(*panel);
  const ScoreMap& map = harness.context.analysis->score_map.value();
  EXPECT_EQ(map.problem, "");
  EXPECT_EQ(map.category, objects[0].category);
  EXPECT_EQ(harness.textures.pictures_made, before + 1);
  // The fake run's proposals are the objects' boxes: the highest score is where the object is.
  cv::Point best;
  double highest = 0;
  cv::minMaxLoc(map.scores, nullptr, &highest, nullptr, &best);
  EXPECT_GT(highest, 0.3);
  const Box2& box = objects[0].visible_box;
  EXPECT_NEAR(best.x * map.step_px, box.center_x(), 0.25 * map.width_px);
  EXPECT_NEAR(best.y * map.step_px, box.center_y(), 0.25 * map.height_px);
  harness.context.selection.object = {};
  harness.Analyse({}, {.score_map = true});
  EXPECT_NE(harness.context.analysis->score_map->problem, "");
  harness.Draw(*panel);
}

TEST(EdgesPanel, PutsOtherEdgesBesideThoseOfTheRun) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("edges");
  harness.ShowFrame(20);
  harness.Click(*panel, "edges.beside");
  ASSERT_NE(harness.sink.Last<NeedCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<NeedCommand>()->edges, "builtin");
  harness.Draw(*panel);  // before they are there
  const int before = harness.textures.pictures_made;
  harness.Analyse({}, {.edges = "builtin"});
  const OtherEdges& other = harness.context.analysis->other_edges.value();
  EXPECT_EQ(other.problem, "");
  EXPECT_EQ(other.probability.size(), harness.context.snapshot->image.size());
  harness.Draw(*panel);
  EXPECT_EQ(harness.textures.pictures_made, before + 1);
  harness.Drag(*panel, "edges.divider", {0.5f, 0.5f}, {5.5f, 0.5f}, 0);
  EXPECT_GT(panel->SaveState()["divider"].get<double>(), 0.52);
  EXPECT_EQ(harness.viewport.center.x, 0.5) << "the picture stays where it is";
  harness.Click(*panel, "edges.blink");
  EXPECT_TRUE(panel->SaveState()["blink"].get<bool>());
  harness.Click(*panel, "edges.beside");
  EXPECT_EQ(harness.sink.Last<NeedCommand>()->edges, "builtin-half");
  harness.Analyse({}, {.edges = "nowhere.onnx"});
  EXPECT_NE(harness.context.analysis->other_edges->problem, "");
}

TEST(ScenePanel, TurnsByLeftMovesByRightAndZoomsByWheel) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("scene");
  harness.ShowFrame(20);
  harness.Drag(*panel, "scene.view", {0.4f, 0.4f}, {0.6f, 0.4f}, 0);
  EXPECT_GT(harness.scene.orbit_x, 50);
  EXPECT_EQ(harness.scene.pan_x, 0);
  harness.Drag(*panel, "scene.view", {0.4f, 0.4f}, {0.6f, 0.4f}, 1);
  EXPECT_GT(harness.scene.pan_x, 50);
  harness.Wheel(*panel, "scene.view", 2);
  EXPECT_EQ(harness.scene.zoomed, 2);
}

TEST(ScenePanel, AClickThatTremblesOrFollowsAJumpSelectsAndTurnsNothing) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("scene");
  harness.ShowFrame(20);
  for (const int button : {0, 1, 2})
    harness.JumpAndClick(*panel, "scene.view", {0.6f, 0.6f}, {2, -3}, button);
  EXPECT_EQ(harness.scene.orbit_x, 0);
  EXPECT_EQ(harness.scene.orbit_y, 0);
  EXPECT_EQ(harness.scene.pan_x, 0);
  EXPECT_NE(harness.sink.Last<SelectObjectCommand>(), nullptr);
  harness.sink.commands.clear();
  harness.JumpAndClick(*panel, "scene.view", {0.6f, 0.6f}, {5, 0});
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>(), nullptr) << "a drag";
  EXPECT_EQ(harness.scene.orbit_x, 5) << "by the drag alone, not by the jump";
}

TEST(ScenePanel, TheWheelKeepsWhatIsUnderTheMouse) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("scene");
  harness.ShowFrame(20);
  harness.Point(*panel, "scene.view", 0.75f, 0.5f);
  const auto rect = *harness.widgets.Find("scene.view");
  ImGui::GetIO().MouseWheel = 1;
  harness.Draw(*panel);
  EXPECT_EQ(harness.scene.zoomed, 1);
  // A quarter of the view from its middle, which grows to 1 / 0.88 of it.
  EXPECT_NEAR(harness.scene.pan_x, -0.25 * (rect.high.x - rect.low.x) * (1 / 0.88 - 1), 0.5);
}

TEST(ScenePanel, SelectsWhatIsClicked) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("scene");
  harness.ShowFrame(20);
  harness.Click(*panel, "scene.view");
  ASSERT_NE(harness.sink.Last<SelectObjectCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>()->object, ObjectId{2});
}

TEST(ScenePanel, MeasuresBetweenTwoClicks) {
  EXPECT_EQ(TapeReading({1, 1, 0.5}, {4, 5, 0.25}, {0, 0, 1}), "5.006 m\n5.000 across, 0.250 down");
  Tape tape;
  for (int i = 0; i < 3; ++i) tape.Add(Eigen::Vector3d(i, 0, 0));
  ASSERT_EQ(tape.points.size(), 1u) << "a third point begins anew";
  EXPECT_EQ(tape.points[0].x(), 2);

  PanelHarness harness;
  const auto panel = MakeInspectPanel("scene");
  harness.ShowFrame(20);
  panel->LoadState({{"tape", true}, {"parallel", true}});
  harness.Click(*panel, "scene.view", 0.25f, 0.5f);
  const int with_one = harness.vertices;
  harness.Click(*panel, "scene.view", 0.5f, 0.5f);
  ASSERT_EQ(harness.scene.points_asked.size(), 2u);
  EXPECT_NEAR(harness.scene.points_asked[1].x() - harness.scene.points_asked[0].x(),
              0.25 * harness.size.x, 8);
  EXPECT_NE(harness.vertices, with_one);
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>(), nullptr) << "a click measures";
  EXPECT_TRUE(harness.scene.content.parallel);
  EXPECT_TRUE(panel->SaveState().at("tape").get<bool>());
  panel->LoadState({{"tape", false}});
  harness.Click(*panel, "scene.view");
  EXPECT_NE(harness.sink.Last<SelectObjectCommand>(), nullptr);
}

TEST(ScenePanel, PassesItsLayersOn) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("scene");
  harness.size = {900, 420};
  harness.ShowFrame(20);
  harness.Click(*panel, "scene.truth");
  EXPECT_TRUE(harness.scene.content.layers.truth);
  harness.Click(*panel, "scene.follow");
  ASSERT_NE(harness.sink.Last<FollowCommand>(), nullptr);
  EXPECT_TRUE(harness.sink.Last<FollowCommand>()->follow);
}

TEST(ScenePanel, GhostsFadeWithTheProbabilityThatTheyAreThere) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("scene");
  harness.ShowFrame(20);
  MapSnapshot snapshot = *harness.context.snapshot;
  ASSERT_GT(snapshot.report.objects.size(), 2u);
  snapshot.report.objects[0].state = ObjectState::kConfirmed;
  snapshot.report.objects[1].state = snapshot.report.objects[2].state = ObjectState::kTentative;
  snapshot.report.objects[1].log_evidence = -2;
  snapshot.report.objects[2].log_evidence = 2;
  harness.context.snapshot = std::make_shared<const MapSnapshot>(snapshot);
  harness.Draw(*panel);
  const auto opacity = [&](std::size_t i) {
    for (const SceneObject& object : harness.scene.content.objects) {
      if (object.id == snapshot.report.objects[i].id) return object.opacity;
    }
    return -1.0f;
  };
  EXPECT_EQ(opacity(0), 1.0f);
  EXPECT_LT(opacity(1), opacity(2));
  EXPECT_LT(opacity(2), 0.6f);
  EXPECT_GT(opacity(1), 0.05f);
  panel->LoadState({{"opacity", 0.3}});
  harness.Draw(*panel);
  EXPECT_NEAR(opacity(0), 0.3f, 1e-6f);
}

TEST(ScenePanel, LeavesOutWhatIsNotConfirmedButForTheSelectedObject) {
  PanelHarness harness;
  const auto scene = MakeInspectPanel("scene"), objects = MakeInspectPanel("objects");
  harness.ShowFrame(20);
  MapSnapshot snapshot = *harness.context.snapshot;
  for (ObjectReport& object : snapshot.report.objects) object.state = ObjectState::kTentative;
  snapshot.report.objects[0].state = ObjectState::kConfirmed;
  harness.context.snapshot = std::make_shared<const MapSnapshot>(snapshot);
  harness.context.confirmed_only = true;
  harness.Draw(*scene);
  EXPECT_EQ(harness.scene.content.objects.size(), 1u);
  harness.context.selection.object = snapshot.report.objects[1].id;
  harness.Draw(*scene);
  EXPECT_EQ(harness.scene.content.objects.size(), 2u);
  harness.Draw(*objects);
  const auto row = [&](std::size_t i) {
    return harness.widgets.Find("objects.row." +
                                std::to_string(snapshot.report.objects[i].id.value));
  };
  EXPECT_NE(row(0), nullptr);
  EXPECT_NE(row(1), nullptr);
  EXPECT_EQ(row(2), nullptr);
}

TEST(ImagePanel, WeakProposalsHaveNoText) {
  PanelHarness harness;
  harness.size = {900, 420};
  const auto panel = MakeInspectPanel("image");
  harness.ShowFrame(20);
  MapSnapshot snapshot = *harness.context.snapshot;
  ProposalReport weak;
  weak.category = "chair";
  weak.fate = ProposalFate::kLowScore;
  weak.box = {20, 20, 60, 60};
  snapshot.report.proposals = {weak};
  harness.context.snapshot = std::make_shared<const MapSnapshot>(snapshot);
  panel->LoadState({{"names", false}, {"outlines", false}});
  harness.Draw(*panel);
  const int without = harness.vertices;
  panel->LoadState({{"weak", true}});
  harness.Draw(*panel);
  EXPECT_GT(harness.vertices, without);
  EXPECT_LT(harness.vertices, without + 60) << "a box, and not a letter";
}

TEST(TimingsPanel, GoesToThePeakThatIsClicked) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("timings");
  harness.ShowFrame(20);
  auto history = std::make_shared<RunHistory>();
  for (int i = 0; i < 50; ++i) {
    FrameSample sample;
    sample.frame = i;
    sample.timings = {{"update", i == 30 ? 90.0 : 10.0}};
    history->frames.push_back(std::make_shared<const FrameSample>(sample));
  }
  PlaybackView playback = *harness.context.playback;
  playback.history = history;
  harness.context.playback = std::make_shared<const PlaybackView>(playback);
  panel->LoadState({{"over_time", true}});
  harness.Click(*panel, "timings.plot", 30.5f / 50, 0.3f);
  ASSERT_NE(harness.sink.Last<SeekCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SeekCommand>()->frame, 30);
}

TEST(TimingsPanel, ShowsTheWholeRunAndItsSlowestFrames) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("timings");
  harness.ShowFrame(20);
  harness.Click(*panel, "timings.whole_run");
  const NeedCommand* need = harness.sink.Last<NeedCommand>();
  ASSERT_NE(need, nullptr);
  EXPECT_EQ(need->what, NeedCommand::What::kTimings);
  TimingStatistics statistics;
  statistics.frames = 600;
  statistics.stages = {{"update", 11, 10, 15, 200, 123}};
  statistics.all = {"all", 11, 10, 15, 200, 123};
  statistics.slowest = {{123, 200, "update", 200}, {45, 90, "update", 90}};
  harness.context.timings = std::make_shared<const TimingStatistics>(statistics);
  harness.Click(*panel, "timings.stage.update");
  ASSERT_NE(harness.sink.Last<SeekCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SeekCommand>()->frame, 123);
  harness.Click(*panel, "timings.slow.1");
  EXPECT_EQ(harness.sink.Last<SeekCommand>()->frame, 45);
}

TEST(ObjectsPanel, SelectsARow) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("objects");
  harness.ShowFrame(20);
  harness.Click(*panel, "objects.row.4");
  ASSERT_NE(harness.sink.Last<SelectObjectCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>()->object, ObjectId{4});
}

TEST(TimelinePanel, PostsWhatItsButtonsSay) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("timeline");
  harness.size = {900, 90};
  harness.ShowFrame(20);
  harness.Click(*panel, "timeline.play");
  EXPECT_NE(harness.sink.Last<TogglePlayCommand>(), nullptr);
  harness.Click(*panel, "timeline.back");
  EXPECT_EQ(harness.sink.Last<StepCommand>()->frames, -1);
  harness.Click(*panel, "timeline.forward");
  EXPECT_EQ(harness.sink.Last<StepCommand>()->frames, 1);
  harness.Click(*panel, "timeline.first");
  EXPECT_EQ(harness.sink.Last<SeekCommand>()->frame, 0);
  harness.Click(*panel, "timeline.last");
  EXPECT_EQ(harness.sink.Last<SeekCommand>()->frame, 40);
}

TEST(StatusBar, NeverTellsOfFewerThanNoFramesToGo) {
  PanelHarness harness;
  harness.ShowFrame(20);
  PlaybackView playback = *harness.context.playback;
  playback.recorded = true;
  playback.newest_mapped_frame = 399;
  playback.seek_target = 0;
  harness.context.playback = std::make_shared<const PlaybackView>(playback);
  EXPECT_EQ(InspectStatus(harness.context).text, "Going to frame 0");
  playback.seek_target = 420;
  harness.context.playback = std::make_shared<const PlaybackView>(playback);
  EXPECT_THAT(InspectStatus(harness.context).text, testing::HasSubstr("21 to go"));
}

TEST(StatusBar, TellsHowALiveRunFares) {
  PanelHarness harness;
  harness.ShowFrame(20);
  PlaybackView playback = *harness.context.playback;
  playback.live = LiveReport{.taken = 8, .done = 7, .passed_over = 13, .done_age_ms = 171.4};
  const auto status = [&](PlaybackState state) {
    playback.state = state;
    harness.context.playback = std::make_shared<const PlaybackView>(playback);
    return InspectStatus(harness.context).text;
  };
  EXPECT_EQ(
      status(PlaybackState::kPlaying)
          .find("Live, frame 20: 7 of 21 frames mapped as they came, 13 passed over; 171 ms old"),
      0u);
  EXPECT_EQ(status(PlaybackState::kPaused),
            "Paused; what comes now is passed over. Space goes on. So far 7 of 21 frames mapped as "
            "they came, 13 passed over.");
  EXPECT_EQ(status(PlaybackState::kFinished),
            "At the end: 7 of 21 frames mapped as they came, 13 passed over.");
  playback.message = "the disk is full";
  EXPECT_EQ(status(PlaybackState::kFailed), "the disk is full");
}

TEST(TimelinePanel, SeeksWhereItIsClickedAndFollowsADrag) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("timeline");
  harness.size = {900, 90};
  harness.ShowFrame(20);
  harness.Click(*panel, "timeline.track", 0.5f, 0.6f);
  ASSERT_NE(harness.sink.Last<SeekCommand>(), nullptr);
  EXPECT_NEAR(harness.sink.Last<SeekCommand>()->frame, 30, 1);
  harness.sink.commands.clear();
  harness.Drag(*panel, "timeline.track", {0.5f, 0.6f}, {0.8f, 0.6f}, 0);
  EXPECT_NEAR(harness.sink.Last<SeekCommand>()->frame, 48, 1);
}

/// So many confirmed objects, and options that changed in frame 15.
PlaybackView Crowd(const PlaybackView& before, int objects) {
  PlaybackView playback = before;
  std::vector<FrameEvent> events;
  for (int i = 1; i <= objects; ++i) {
    events.push_back({1, {EventKind::kSpawned, {i}, {}, ""}});
    events.push_back({5, {EventKind::kConfirmed, {i}, {}, ""}});
  }
  events.push_back({15, {EventKind::kOptionsChanged, {}, {}, "alpha 2.5 -> 4.0"}});
  playback.events = std::make_shared<const std::vector<FrameEvent>>(events);
  return playback;
}

int LanesIn(const WidgetLog& widgets) {
  return static_cast<int>(
      std::count_if(widgets.rects().begin(), widgets.rects().end(),
                    [](const auto& entry) { return entry.first.starts_with("timeline.lane."); }));
}

TEST(TimelinePanel, ScrollsLanesThatStayLargeEnoughToRead) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("timeline");
  harness.size = {1200, 260};
  harness.ShowFrame(20);
  harness.context.playback =
      std::make_shared<const PlaybackView>(Crowd(*harness.context.playback, 21));
  harness.Draw(*panel, 2);
  const int shown = LanesIn(harness.widgets);
  EXPECT_GE(shown, 4);
  EXPECT_LT(shown, 21);
  const WidgetLog::Rect first = *harness.widgets.Find("timeline.lane.1");
  EXPECT_GE(first.high.y - first.low.y, 18);
  EXPECT_EQ(harness.widgets.Find("timeline.lane.21"), nullptr);
  harness.Wheel(*panel, "timeline.lanes", -50);
  ASSERT_NE(harness.widgets.Find("timeline.lane.21"), nullptr);
  harness.Click(*panel, "timeline.lane.21");
  ASSERT_NE(harness.sink.Last<SelectObjectCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>()->object, ObjectId{21});
  EXPECT_EQ(harness.sink.Last<SeekCommand>(), nullptr) << "a name is no place in time";
  harness.context.selection.object = {2};
  harness.Draw(*panel, 2);
  EXPECT_NE(harness.widgets.Find("timeline.lane.2"), nullptr) << "what is selected comes into view";
}

TEST(TimelinePanel, ShowsTheLanesOfTheRunThatShows) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("timeline");
  harness.size = {1200, 260};
  harness.ShowFrame(20);
  harness.context.playback =
      std::make_shared<const PlaybackView>(Crowd(*harness.context.playback, 3));
  auto other = std::make_shared<OtherRun>();
  other->playback = std::make_shared<const PlaybackView>(Crowd(*harness.context.playback, 2));
  harness.context.other = other;
  harness.Draw(*panel, 2);
  EXPECT_EQ(LanesIn(harness.widgets), 3);
  harness.context.shows_other = true;
  harness.Draw(*panel, 2);
  EXPECT_EQ(LanesIn(harness.widgets), 2);
  harness.Point(*panel, "timeline.track", 0.25f, 0.3f);  // the mark's tooltip
}

}  // namespace
}  // namespace plumbline
