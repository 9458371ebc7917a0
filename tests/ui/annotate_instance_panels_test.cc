// SPDX-License-Identifier: Apache-2.0
// Models and placed objects in the Annotate workspace without a display.

#include "ui/annotate/annotate_panels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/ui/annotate_harness.h"

namespace plumbline {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(AnnotateModelsPanel, AClickChoosesWhatIsPlacedNextAndASecondOneDoesNot) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_models");
  harness.Click(*panel, "annotate_models.table");
  EXPECT_EQ(harness.view.tool, AnnotateTool::kPlace);
  EXPECT_EQ(harness.view.model, "table");
  EXPECT_NE(harness.sink.Last<CancelProposalCommand>(), nullptr);
  harness.Click(*panel, "annotate_models.table");
  EXPECT_EQ(harness.view.tool, AnnotateTool::kSelect);
  EXPECT_GT(harness.textures.pictures_made, 1);
}

TEST(AnnotateModelsPanel, TheFilterKeepsWhatFits) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_models");
  harness.Type(*panel, "annotate_models.filter", "DINING");
  EXPECT_EQ(harness.widgets.Find("annotate_models.armchair"), nullptr);
  EXPECT_NE(harness.widgets.Find("annotate_models.table"), nullptr) << "by its category";
  harness.snapshot().models = AnnotationSnapshot().models;
  harness.snapshot().models_problem = "The folder is empty.";
  EXPECT_EQ(harness.widgets.Find("annotate_models.none"), nullptr);
  harness.Draw(*panel);
  EXPECT_EQ(harness.widgets.Find("annotate_models.table"), nullptr);
}

TEST(AnnotateInstancesPanel, CtrlSelectsOneMoreAndWhatIsDoneIsDoneToAllAtOnce) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instances");
  ASSERT_EQ(harness.snapshot().selected, "armchair_0");
  ImGui::GetIO().KeyCtrl = true;
  harness.Click(*panel, "annotate_instances.row.table_0", 0.2f);
  ImGui::GetIO().KeyCtrl = false;
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.view.also_selected, std::vector<std::string>{"table_0"});
  harness.Click(*panel, "annotate_instances.hide.table_0");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->and_also,
            std::vector<std::string>{"armchair_0"});
  harness.Press(keys::kDelete);
  EXPECT_EQ(harness.sink.Last<RemoveInstanceCommand>()->id, "armchair_0");
  EXPECT_EQ(harness.sink.Last<RemoveInstanceCommand>()->and_also,
            std::vector<std::string>{"table_0"});
  harness.Click(*panel, "annotate_instances.row.table_0", 0.2f);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "table_0");
  EXPECT_TRUE(harness.view.also_selected.empty());
}

TEST(AnnotateInstancesPanel, ListsWhatIsWrongAndGoesThere) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instances");
  harness.snapshot().checklist.findings = {
      {"floating", "table_0 floats 0.050 m above the floor", {"table_0"}, true},
      {"missing_frames", "3 of 20 frames of the sequence have no camera pose", {}, false}};
  harness.Click(*panel, "annotate_instances.check");
  EXPECT_TRUE(harness.view.check);
  harness.Click(*panel, "finding.0");
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "table_0");
  EXPECT_EQ(harness.view.focus_on, "table_0");
  harness.Press(keys::kN);
  EXPECT_EQ(harness.view.finding, 1);
  harness.Press(keys::kN);
  EXPECT_EQ(harness.view.finding, 0) << "around";
  harness.Press(keys::kN, false, true);
  EXPECT_EQ(harness.view.finding, 1);
}

TEST(AnnotateInstancesPanel, AFindingIsCalledAllRightAndOpenedAgain) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instances");
  FindingView finding{"floating", "table_0 floats 0.050 m above the floor", {"table_0"}, true};
  finding.can_accept = true;
  harness.snapshot().checklist.findings = {finding};
  harness.view.check = true;
  harness.Click(*panel, "finding.0");
  harness.Press(keys::kO);
  EXPECT_TRUE(harness.view.accept_finding);
  harness.Draw(*panel);
  harness.view.finding_note = "a rug lies under it";
  harness.Click(*panel, "finding.accept.done");
  ASSERT_TRUE(harness.sink.Last<AcceptFindingCommand>());
  EXPECT_EQ(harness.sink.Last<AcceptFindingCommand>()->kind, "floating");
  EXPECT_EQ(harness.sink.Last<AcceptFindingCommand>()->instances,
            std::vector<std::string>{"table_0"});
  EXPECT_EQ(harness.sink.Last<AcceptFindingCommand>()->note, "a rug lies under it");
  EXPECT_TRUE(harness.sink.Last<AcceptFindingCommand>()->accepted);

  finding.accepted = true;
  finding.accepted_by = "Ada";
  harness.snapshot().checklist.findings = {finding};
  EXPECT_EQ(harness.snapshot().checklist.NumErrors(), 0);
  harness.Click(*panel, "finding.0");
  harness.Click(*panel, "finding.reopen");
  EXPECT_FALSE(harness.sink.Last<AcceptFindingCommand>()->accepted);
}

TEST(AnnotateInstancesPanel, ListsHowFarAnotherAnnotatorIsAndShowsBoth) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instances");
  AgreementView agreement;
  agreement.name = "room.grace.json";
  agreement.running = false;
  AgreedRowView both, there;
  both.first = "table_0";
  both.second = "desk";
  both.horizontal_m = 0.012;
  both.height_m = -0.004;
  both.azimuth_rad = 0.02;
  there.second = "stool_7";
  agreement.rows = {both, there};
  harness.snapshot().agreement = agreement;
  const std::string text = harness.Text(*panel);
  for (const char* part :
       {"room.grace.json", "table_0", "1.2", "-0.4 cm", "1.1\u00b0", "stool_7", "only there"})
    EXPECT_THAT(text, HasSubstr(part));
  harness.Click(*panel, "agreement.0");
  EXPECT_EQ(harness.view.agreed_row, 0);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "table_0");
  EXPECT_EQ(harness.view.focus_on, "table_0");
  harness.Click(*panel, "agreement.1");
  EXPECT_EQ(harness.view.agreed_row, 1);
  harness.Click(*panel, "agreement.close");
  EXPECT_EQ(harness.sink.Last<CompareWithCommand>()->file, "");
  EXPECT_EQ(harness.view.agreed_row, -1);
}

TEST(AnnotateInstancesPanel, SelectsHidesLocksAndGradesARow) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instances");
  EXPECT_THAT(harness.Text(*panel), HasSubstr("2 objects"));
  harness.Click(*panel, "annotate_instances.row.table_0", 0.2f);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "table_0");
  harness.Click(*panel, "annotate_instances.hide.table_0");
  const auto* change = harness.sink.Last<ChangeInstanceCommand>();
  ASSERT_NE(change, nullptr);
  EXPECT_EQ(change->id, "table_0");
  EXPECT_EQ(change->set.hidden, true);
  EXPECT_FALSE(change->set.locked || change->set.fine);
  harness.snapshot().instances[1].locked = true;
  harness.Click(*panel, "annotate_instances.lock.table_0");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.locked, false);
  harness.Click(*panel, "annotate_instances.quality.table_0");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.fine, false);
}

TEST(AnnotateInstancePanel, TypedNumbersMoveTheObjectOnceTheyAreLeft) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  EXPECT_THAT(harness.Text(*panel), HasSubstr("Ada, 1 min 15 s spent"));
  harness.Type(*panel, "instance.x", "2.5");
  const auto* moved = harness.sink.Last<SetInstancePoseCommand>();
  ASSERT_NE(moved, nullptr);
  EXPECT_LT((moved->scan_from_object.translation() - Eigen::Vector3d(2.5, -1, 0)).norm(), 1e-9);
  EXPECT_EQ(harness.sink.commands.size(), 1u) << "one edit, not one for each digit";
  harness.Type(*panel, "instance.azimuth", "90");
  moved = harness.sink.Last<SetInstancePoseCommand>();
  EXPECT_NEAR(moved->scan_from_object.linear()(1, 0), 1, 1e-9);
}

TEST(AnnotateInstancePanel, ANumberCountsHoweverItsFieldIsLeft) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  harness.Type(*panel, "instance.x", "2.5", keys::kTab);
  const auto* moved = harness.sink.Last<SetInstancePoseCommand>();
  ASSERT_NE(moved, nullptr);
  EXPECT_NEAR(moved->scan_from_object.translation().x(), 2.5, 1e-9);
  // Tab has gone to the next field; a click on one above leaves that.
  ImGui::GetIO().AddInputCharactersUTF8("-3.25");
  harness.Draw(*panel, 2);
  harness.Click(*panel, "instance.name");
  ASSERT_EQ(harness.sink.commands.size(), 2u);
  moved = harness.sink.Last<SetInstancePoseCommand>();
  EXPECT_NEAR(moved->scan_from_object.translation().x(), 2.5, 1e-9) << "kept, though on its way";
  EXPECT_NEAR(moved->scan_from_object.translation().y(), -3.25, 1e-9);
}

TEST(AnnotateInstancePanel, WhatIsGivenUpOrSaysNothingNewIsNoEdit) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  harness.Type(*panel, "instance.x", "2.5", keys::kEscape);
  harness.snapshot().instances[0].scan_from_object.translation().x() = 1.00001;
  harness.Type(*panel, "instance.x", "1.00", keys::kTab);
  harness.Type(*panel, "instance.x", "nan", keys::kTab);
  harness.Type(*panel, "instance.x", "", keys::kTab);
  EXPECT_TRUE(harness.sink.commands.empty());
}

TEST(AnnotateInstancePanel, ItsButtonsAskForTheirCommands) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  harness.Click(*panel, "instance.refine");
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->id, "armchair_0");
  harness.Click(*panel, "instance.on_floor", 0.1f);
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->by, RefineBy::kBoth);
  harness.Click(*panel, "instance.by_images");
  EXPECT_FALSE(harness.sink.Last<RefineInstanceCommand>()->on_floor);
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->by, RefineBy::kImages);
  harness.Click(*panel, "instance.by_scan");
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->by, RefineBy::kScan);
  harness.Click(*panel, "instance.again");
  EXPECT_EQ(harness.sink.Last<PlaceAgainCommand>()->id, "armchair_0");
  harness.Click(*panel, "instance.duplicate");
  EXPECT_EQ(harness.sink.Last<DuplicateInstanceCommand>()->id, "armchair_0");
  harness.Click(*panel, "instance.copy");
  ASSERT_TRUE(harness.view.copied.has_value());
  harness.snapshot().selected = "table_0";
  harness.Press(keys::kV, true);
  EXPECT_EQ(harness.sink.Last<DuplicateInstanceCommand>()->id, "armchair_0")
      << "beside what was copied, whatever is selected";
  harness.Click(*panel, "instance.tilt");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->id, "table_0");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.may_tilt, true);
  harness.Click(*panel, "instance.paste");
  EXPECT_EQ(harness.sink.Last<SetInstancePoseCommand>()->id, "table_0");
  EXPECT_EQ(harness.sink.Last<SetInstancePoseCommand>()->scan_from_object.translation().x(), 1);
  harness.Click(*panel, "instance.coarse");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.fine, false);
  harness.Click(*panel, "instance.delete");
  EXPECT_EQ(harness.sink.Last<RemoveInstanceCommand>()->id, "table_0");
  harness.snapshot().instances[1].locked = true;
  harness.sink.commands.clear();
  harness.Click(*panel, "instance.delete");
  EXPECT_TRUE(harness.sink.commands.empty()) << "locked";
}

TEST(AnnotateInstancePanel, NameAndNoteBecomeEditsAndFollowUndo) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  AnnotatedInstance& chair = harness.snapshot().instances[0];
  harness.Type(*panel, "instance.name", "throne");
  ASSERT_NE(harness.sink.Last<ChangeInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.id, "throne");
  chair.note = "wobbles";
  EXPECT_THAT(harness.Text(*panel), HasSubstr("wobbles"));
  chair.note.clear();  // it was undone
  EXPECT_THAT(harness.Text(*panel), Not(HasSubstr("wobbles")));
  const std::string note(300, 'x');
  chair.note = note;
  harness.Draw(*panel);
  harness.sink.commands.clear();
  harness.Click(*panel, "instance.note");
  ImGui::GetIO().AddInputCharacter('y');
  harness.Draw(*panel, 2);
  harness.Click(*panel, "instance.name");
  ASSERT_NE(harness.sink.Last<ChangeInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.note->size(), 301u)
      << "a long note is not cut";
}

}  // namespace
}  // namespace plumbline
