// SPDX-License-Identifier: Apache-2.0
// Panels of the Annotate workspace without a display, all of them and the bar over them: what they
// say, what they post, and that no state of a project upsets them.

#include "ui/annotate/annotate_panels.h"

#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/ui/annotate_harness.h"

namespace plumbline {
namespace {

std::vector<std::unique_ptr<Panel>> AllPanels() {
  std::vector<std::unique_ptr<Panel>> panels;
  for (const AnnotatePanelEntry& entry : AnnotatePanels())
    panels.push_back(MakeAnnotatePanel(entry.info.id));
  return panels;
}

void FillEverything(AnnotationSnapshot& snapshot) {
  snapshot.floor = MadeUpFloor();
  snapshot.placement = MadeUpPlacement();
  snapshot.refinement = MadeUpRefinement();
  snapshot.sequence_alignment = MadeUpAlignment();
  snapshot.crop = MadeUpCrop();
  snapshot.checks = MadeUpChecks();
  snapshot.frame = FrameView{3, cv::Mat(90, 160, CV_8UC3, cv::Scalar(60, 60, 60)), ""};
  snapshot.pairs = {{{1, -1, 0}, 3, {40, 50}, Eigen::Vector2d(44, 53), 5},
                    {{2, -1, 0}, 7, {40, 50}, std::nullopt, 0}};
  snapshot.notices = {"3 edits recovered"};
  snapshot.num_recovered = 3;
  snapshot.journal_problem = "no room";
}

/// The bar over the workspace, as if it were a panel.
class ProjectBar : public Panel {
 public:
  ProjectBar() {
    PanelInfo info;
    info.id = "project_bar";
    set_info(info);
  }
  void Draw(const FrameContext& context, CommandSink& sink) override {
    const ImVec2 low = ImGui::GetCursorScreenPos();
    DrawProjectBar(context, {low, {low.x + 1060, low.y + 40}}, sink);
  }
};

TEST(AnnotatePanels, DrawInEveryStateOfAProject) {
  const std::vector<std::function<void(AnnotationSnapshot&)>> states = {
      [](AnnotationSnapshot& s) { s = AnnotationSnapshot(); },
      [](AnnotationSnapshot&) {},
      [](AnnotationSnapshot& s) { s.selected.clear(); },
      [](AnnotationSnapshot& s) { s.selected = "nobody"; },
      [](AnnotationSnapshot& s) { s.models = AnnotationSnapshot().models; },
      [](AnnotationSnapshot& s) { s.read_only = true; },
      [](AnnotationSnapshot& s) {
        s.placement = PlacementView();
        s.refinement = RefinementView();
        s.sequence_alignment = SequenceAlignmentView();
        s.crop = CropView();
        s.checks = ImageChecksView();
        s.frame = FrameView();
      },
      FillEverything};
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (const auto& panel : AllPanels()) {
      SCOPED_TRACE(std::string(panel->id()) + " in state " + std::to_string(i));
      AnnotateHarness harness;
      states[i](harness.snapshot());
      harness.Draw(*panel, 3);
      EXPECT_GT(harness.vertices, 0);
      const std::string id = panel->id();
      const bool asks = id == "annotate_frame" || id == "annotate_masks";  // for the first frame
      EXPECT_TRUE(asks || harness.sink.commands.empty()) << "nobody asked for anything";
      for (const ImVec2 size : {ImVec2(12, 12), ImVec2(90, 700), ImVec2(900, 60)}) {
        harness.size = size;
        harness.Draw(*panel, 2);
      }
    }
  }
}

TEST(AnnotateExport, AsksBeforeItReplacesAndPassesTheAnswerOn) {
  AnnotateHarness harness;
  harness.size = {1100, 640};
  ProjectBar bar;
  harness.snapshot().project_file = "made_up.json";
  ExportView exported{false, "", "2 objects written"};
  exported.asks = true;
  exported.out = "/data/ground_truth.json";
  exported.differences = {"1 object would be gone: chair_3."};
  harness.snapshot().exported = exported;
  harness.Click(bar, "project.export");
  harness.Click(bar, "export.write");
  EXPECT_TRUE(harness.sink.commands.empty()) << "not while it asks";
  harness.Click(bar, "export.leave");
  ASSERT_NE(harness.sink.Last<AnswerExportCommand>(), nullptr);
  EXPECT_FALSE(harness.sink.Last<AnswerExportCommand>()->replace);
  harness.Click(bar, "export.replace");
  EXPECT_TRUE(harness.sink.Last<AnswerExportCommand>()->replace);
}

TEST(AnnotateProjectBar, ButtonsStayWhereTheyAreWhateverTheySay) {
  AnnotateHarness harness;
  harness.size = {1100, 420};
  ProjectBar bar;
  harness.snapshot().project_file = "made_up.json";
  harness.Draw(bar, 2);
  const float before = harness.widgets.Find("project.export")->low.x;
  harness.snapshot().undo_label = "Move a_chair_with_a_very_long_name_indeed_0";
  harness.snapshot().redo_label = "Add";
  harness.snapshot().modified = true;
  harness.Draw(bar, 2);
  EXPECT_EQ(harness.widgets.Find("project.export")->low.x, before);
  harness.snapshot().journal_problem = "no room";
  harness.Draw(bar, 2);
  EXPECT_EQ(harness.widgets.Find("project.export")->low.x, before);
}

TEST(AnnotateBanners, AskForTheUnitOfAScanThatIsTooLarge) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.snapshot().instances.clear();
  harness.snapshot().doubted_size_m = 5230;
  harness.Draw(*panel, 2);
  harness.Click(*panel, "annotate.unit.mm");
  ASSERT_NE(harness.sink.Last<SetScanUnitCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SetScanUnitCommand>()->metres_per_unit, 0.001);
  harness.Click(*panel, "annotate.unit.m");
  EXPECT_EQ(harness.sink.Last<SetScanUnitCommand>()->metres_per_unit, 1);
}

TEST(AnnotateProjectBar, ExportsFragmentsWithoutObjectsButNotNothing) {
  AnnotateHarness harness;
  harness.size = {1100, 420};
  ProjectBar bar;
  harness.snapshot().project_file = "made_up.json";
  harness.snapshot().instances.clear();
  harness.Click(bar, "project.export");
  EXPECT_EQ(harness.widgets.Find("export.write"), nullptr);
  harness.Point(bar, "project.export");
  harness.snapshot().num_fragments = 1;
  harness.Click(bar, "project.export");
  EXPECT_NE(harness.widgets.Find("export.write"), nullptr);
}

/// The sheet, as if it were a panel.
class QueueSheet : public Panel {
 public:
  QueueSheet() {
    PanelInfo info;
    info.id = "queue_sheet";
    set_info(info);
  }
  void Draw(const FrameContext& context, CommandSink& sink) override { DrawQueue(context, sink); }
};

TEST(AnnotateQueue, HandsOverAndLetsSomebodyElseJudge) {
  AnnotateHarness harness;
  QueueSheet sheet;
  harness.size = {720, 480};
  harness.snapshot().annotator = "Ada";
  harness.snapshot().stage = WorkStage::kInWork;
  harness.Type(sheet, "queue.note", "mind the lamp");
  harness.Click(sheet, "queue.hand_over");
  ASSERT_NE(harness.sink.Last<SetStageCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SetStageCommand>()->stage, WorkStage::kToReview);
  EXPECT_EQ(harness.sink.Last<SetStageCommand>()->note, "mind the lamp");
  harness.snapshot().stage = WorkStage::kToReview;
  harness.snapshot().project_state = ProjectState{WorkStage::kToReview, "Ada", "", "mind the lamp"};
  const std::string own = harness.Text(sheet);
  EXPECT_THAT(own, HasSubstr("handed over by Ada"));
  EXPECT_THAT(own, HasSubstr("somebody else reviews it"));
  EXPECT_EQ(harness.widgets.Find("queue.done"), nullptr);
  harness.snapshot().annotator = "Grace";
  harness.Click(sheet, "queue.done");
  EXPECT_EQ(harness.sink.Last<SetStageCommand>()->stage, WorkStage::kDone);
  harness.Click(sheet, "queue.back");
  EXPECT_EQ(harness.sink.Last<SetStageCommand>()->stage, WorkStage::kInWork);
}

TEST(AnnotateQueue, ListsTheFolderAndOpensWhatIsClicked) {
  AnnotateHarness harness;
  QueueSheet sheet;
  harness.size = {720, 480};
  AnnotationQueueView queue;
  queue.folder = "/scans";
  queue.entries = {{"a.ply", "/scans/a.ply"},
                   {"b.json", "/scans/b.json", WorkStage::kDone, {"Ada"}, "Grace", "", 7, 840, ""},
                   {"c.json", "/scans/c.json", WorkStage::kNew, {}, "", "", 0, 0, "is damaged"}};
  queue.open = 1;
  harness.snapshot().queue = queue;
  const std::string text = harness.Text(sheet);
  EXPECT_THAT(text, HasSubstr("Ada; reviewed by Grace"));
  EXPECT_THAT(text, HasSubstr("14 min"));
  EXPECT_THAT(text, HasSubstr("cannot be read"));
  EXPECT_THAT(text, HasSubstr("2 new, 1 done; 7 objects in 14 min"));
  harness.Click(sheet, "queue.row.b.json", 0.1f);
  EXPECT_EQ(harness.sink.Last<OpenCommand>(), nullptr) << "it is open";
  harness.Click(sheet, "queue.row.a.ply", 0.1f);
  ASSERT_NE(harness.sink.Last<OpenCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<OpenCommand>()->path, "/scans/a.ply");
  harness.Type(sheet, "queue.folder", "/more");
  EXPECT_EQ(harness.sink.Last<ListQueueCommand>()->folder, "/more");
}

}  // namespace
}  // namespace plumbline
