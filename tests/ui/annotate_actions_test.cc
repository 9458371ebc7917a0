// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_actions.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/ui/annotate_harness.h"
#include "ui/annotate/annotate_edits.h"
#include "ui/common/window_actions.h"
#include "ui/framework/actions.h"

namespace plumbline {
namespace {

Eigen::Isometry3d At(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

AnnotationSnapshot WithChairAt(double x, std::uint64_t last_command) {
  AnnotationSnapshot snapshot;
  AnnotatedInstance chair;
  chair.id = "chair_0";
  chair.scan_from_object = At(x);
  snapshot.instances = {chair};
  snapshot.last_command.number = last_command;
  return snapshot;
}

TEST(FollowSnapshot, APoseIsShownUntilItsCommandWasCarriedOut) {
  AnnotateView view;
  view.pending = PendingPose{"chair_0", At(2), std::nullopt};
  // Dragged still: another answer, and even another pose, do not end it.
  FollowSnapshot(WithChairAt(0, 3), WithChairAt(1, 4), view);
  ASSERT_TRUE(view.pending.has_value());
  NotePosted(SetInstancePoseCommand{"chair_0", At(2)}, 6, view);
  FollowSnapshot(WithChairAt(1, 4), WithChairAt(1, 5), view);
  EXPECT_TRUE(view.pending.has_value());
  FollowSnapshot(WithChairAt(1, 5), WithChairAt(2, 6), view);
  EXPECT_FALSE(view.pending.has_value());
}

TEST(FollowSnapshot, APoseThatChangesNothingOrIsRefusedEndsToo) {
  AnnotateView view;
  view.pending = PendingPose{"chair_0", At(1), std::nullopt};
  NotePosted(SetInstancePoseCommand{"chair_0", At(1)}, 6, view);
  FollowSnapshot(WithChairAt(1, 5), WithChairAt(1, 7), view);
  EXPECT_FALSE(view.pending.has_value()) << "dragged back to where it was";
  view.pending = PendingPose{"chair_0", At(3), std::nullopt};
  NotePosted(SetInstancePoseCommand{"chair_0", At(3)}, std::nullopt, view);
  EXPECT_FALSE(view.pending.has_value()) << "its command was dropped";
}

TEST(FollowSnapshot, APoseThatMovesOnWaitsForItsOwnCommand) {
  AnnotateView view;
  view.pending = PendingPose{"chair_0", At(2), std::nullopt};
  NotePosted(SetInstancePoseCommand{"chair_0", At(2)}, 6, view);
  view.pending = PendingPose{"chair_0", At(3), std::nullopt};  // nudged again
  FollowSnapshot(WithChairAt(1, 5), WithChairAt(2, 6), view);
  ASSERT_TRUE(view.pending.has_value());
  NotePosted(SetInstancePoseCommand{"somebody_else", At(3)}, 7, view);
  EXPECT_FALSE(view.pending->command.has_value());
}

TEST(FollowSnapshot, AChosenCandidateStaysChosenInItsOwnPlacementOnly) {
  AnnotateView view;
  AnnotationSnapshot before, now;
  before.placement = now.placement = MadeUpPlacement();
  std::swap(now.placement->candidates[0], now.placement->candidates[1]);
  view.candidate = 1;
  FollowSnapshot(before, now, view);
  EXPECT_EQ(view.candidate, 0) << "where the second one is now";
  view.candidate = 1;
  now.placement->asked_by = 9;
  FollowSnapshot(before, now, view);
  EXPECT_EQ(view.candidate, 0) << "the first of another placement";
}

TEST(AnnotateShortcuts, EnterTakesTheCandidateThatShows) {
  AnnotateHarness harness;
  harness.snapshot().placement = MadeUpPlacement();
  harness.Press(keys::kDown);
  EXPECT_EQ(harness.view.candidate, 1);
  harness.Press(keys::kEnter);
  ASSERT_NE(harness.sink.Last<AcceptProposalCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<AcceptProposalCommand>()->candidate, 1);
  harness.Press(keys::kEscape);
  EXPECT_NE(harness.sink.Last<CancelProposalCommand>(), nullptr);
}

TEST(AnnotateShortcuts, EnterKeepsTheToolWhileAProposalIsStillWorkedOn) {
  AnnotateHarness harness;
  harness.view.tool = AnnotateTool::kSequence;
  harness.snapshot().sequence_alignment = SequenceAlignmentView();
  harness.Press(keys::kEnter);
  EXPECT_EQ(harness.view.tool, AnnotateTool::kSequence);
  harness.snapshot().sequence_alignment->running = false;
  harness.Press(keys::kEnter);
  EXPECT_EQ(harness.view.tool, AnnotateTool::kSelect);
}

TEST(AnnotateShortcuts, ANudgeStartsFromTheObjectItselfNotFromAnotherOneOnItsWay) {
  AnnotateHarness harness;
  harness.view.pending = PendingPose{"table_0", At(40), 5};
  harness.Press(keys::kD);
  const auto* moved = harness.sink.Last<SetInstancePoseCommand>();
  ASSERT_NE(moved, nullptr);
  EXPECT_EQ(moved->id, "armchair_0");
  EXPECT_NEAR(moved->scan_from_object.translation().x(), 1.005, 1e-9);
}

TEST(AnnotateShortcuts, KeysOfTheSelectedObject) {
  AnnotateHarness harness;
  harness.Press(keys::kH);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.hidden, true);
  harness.Press(keys::kI);
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->id, "armchair_0");
  harness.Press(keys::kI, false, true);
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->by, RefineBy::kImages);
  harness.Press(keys::kZ, true);
  EXPECT_NE(harness.sink.Last<UndoCommand>(), nullptr);
  harness.Press(keys::kZ, true, true);
  EXPECT_NE(harness.sink.Last<RedoCommand>(), nullptr);
  harness.snapshot().read_only = true;
  harness.sink.commands.clear();
  harness.Press(keys::kDelete);
  EXPECT_TRUE(harness.sink.commands.empty());
}

TEST(AnnotateShortcuts, TabWalksThroughTheObjectsAndComesRound) {
  AnnotateHarness harness;
  const auto selects = [&](bool back) {
    harness.Press(keys::kTab, false, back);
    const auto* command = harness.sink.Last<SelectInstanceCommand>();
    return command == nullptr ? "" : harness.snapshot().selected = command->id;
  };
  EXPECT_EQ(selects(false), "table_0");
  EXPECT_EQ(selects(false), "armchair_0");
  EXPECT_EQ(selects(true), "table_0");
  harness.snapshot().selected.clear();
  EXPECT_EQ(selects(false), "armchair_0") << "the first";
  harness.snapshot().selected.clear();
  EXPECT_EQ(selects(true), "table_0") << "the last";
  harness.snapshot().instances.clear();
  harness.sink.commands.clear();
  harness.Press(keys::kTab);
  EXPECT_TRUE(harness.sink.commands.empty());
}

TEST(AnnotateShortcuts, AModelIsChosenByItsLettersAndEnterPutsItIntoTheMiddle) {
  AnnotateHarness harness;
  harness.Press(keys::kM);
  ASSERT_NE(harness.sink.Last<ShowPaletteCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ShowPaletteCommand>()->within, "Place");
  ChooseModel(harness.context, "table", harness.sink);
  harness.view.view_px = {400, 200};
  for (const int enter : {keys::kEnter, keys::kPadEnter}) {
    harness.sink.commands.clear();
    harness.Press(enter);
    const auto* place = harness.sink.Last<PlaceModelCommand>();
    ASSERT_NE(place, nullptr);
    EXPECT_EQ(place->model, "table");
    EXPECT_NEAR(place->point_in_scan.x(), 2, 1e-9);
    EXPECT_NEAR(place->point_in_scan.y(), -1, 1e-9);
  }
}

TEST(AnnotateActions, EveryOneIsOfferedByWordsWhenItCanBeDoneAndOnlyThen) {
  AnnotateHarness harness;
  const auto actions = AnnotateActions();
  const auto offered = [&](const std::string& text) {
    for (const ActionGroup& group : actions) {
      for (const Action& action : group.actions) {
        const bool on = action.run && action.is_on && action.is_offered(harness.context) &&
                        action.is_on(harness.context);
        if ((on ? action.text_when_on : action.text) == text)
          return !action.is_offered || action.is_offered(harness.context);
      }
    }
    ADD_FAILURE() << "there is no action '" << text << "'";
    return false;
  };
  for (const char* text : {"Put it onto the floor",
                           "Refine: align it to scan and images together",
                           "Try all azimuths",
                           "Refine by the images alone: align its outline to their edges",
                           "Refine by the scan alone",
                           "Go to the next finding",
                           "Hide it",
                           "Lock it",
                           "Delete it",
                           "Duplicate it",
                           "Copy it",
                           "Unlock its tilt",
                           "Unlock its scale",
                           "Queue: the scans of a folder, and how far each is",
                           "Mark it as coarse",
                           "Find the floor",
                           "Undo",
                           "Redo",
                           "Save",
                           "Export",
                           "Cut an object out of the scan",
                           "Register the sequence",
                           "Hide the scan",
                           "Show the path of the cameras"})
    EXPECT_TRUE(offered(text)) << text;
  EXPECT_FALSE(offered("Accept"));
  EXPECT_FALSE(offered("Paste the pose"));
  EXPECT_FALSE(offered("Paste a copy beside the copied object"));
  harness.snapshot().instances[0].hidden = harness.snapshot().instances[0].locked = true;
  EXPECT_TRUE(offered("Show it"));
  EXPECT_TRUE(offered("Unlock it"));
  EXPECT_FALSE(offered("Delete it")) << "it is locked";
  harness.snapshot().placement = MadeUpPlacement();
  EXPECT_TRUE(offered("Accept"));
  EXPECT_FALSE(offered("Select the next object"));
  harness.context.annotation = nullptr;
  for (const ActionGroup& group : actions) {
    for (const Action& action : group.actions) {
      EXPECT_FALSE(action.run && action.is_offered(harness.context)) << action.text;
    }
  }
}

TEST(AnnotateActions, SwitchAndOpenWhatButtonsDo) {
  AnnotateHarness harness;
  harness.Press(keys::kE, true);
  EXPECT_TRUE(harness.view.open_export);
  harness.Press(keys::kS, true, true);
  EXPECT_TRUE(harness.view.open_more);
  harness.Press(keys::kO, true, true);
  EXPECT_TRUE(harness.view.open_queue);
  harness.Press(keys::kK);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.fine, false);
  harness.Press(keys::kC, true);
  harness.snapshot().selected = "table_0";
  harness.Press(keys::kV, true);
  ASSERT_NE(harness.sink.Last<DuplicateInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<DuplicateInstanceCommand>()->id, "armchair_0");
  harness.Press(keys::kV, true, true);
  ASSERT_NE(harness.sink.Last<SetInstancePoseCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SetInstancePoseCommand>()->id, "table_0");
  harness.Press(keys::kDelete);
  EXPECT_EQ(harness.sink.Last<RemoveInstanceCommand>()->id, "table_0");
  harness.Press(keys::kEscape);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "");
}

TEST(AnnotateActions, HideAndShowSeveralObjectsAsBlenderDoes) {
  AnnotateHarness harness;
  harness.Press(keys::kH, false, true);
  ASSERT_NE(harness.sink.Last<ChangeInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->id, "table_0") << "all but the selected";
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.hidden, true);
  harness.sink.commands.clear();
  harness.Press(keys::kH, false, false, true);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>(), nullptr) << "nothing is hidden";
  harness.snapshot().instances[0].hidden = harness.snapshot().instances[1].hidden = true;
  harness.Press(keys::kH, false, false, true);
  ASSERT_NE(harness.sink.Last<ChangeInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->id, "armchair_0");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->and_also,
            std::vector<std::string>{"table_0"});
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.hidden, false);
}

TEST(AnnotateActions, CtrlASelectsAllThatShows) {
  AnnotateHarness harness;
  harness.Press(keys::kA, true);
  EXPECT_EQ(harness.view.also_selected, std::vector<std::string>{"table_0"});
  EXPECT_EQ(harness.sink.Last<SetInstancePoseCommand>(), nullptr) << "A alone moves";
}

TEST(AnnotateActions, TheNumberPadTurnsAndZooms) {
  AnnotateHarness harness;
  harness.context.workspace = WorkspaceId::kAnnotate;
  const std::vector<ActionGroup> views = {ViewActions()};
  const auto press = [&](int key) {
    for (const bool down : {true, false}) {
      ImGui::GetIO().KeysDown[key] = down;
      ImGui::NewFrame();
      RunKeys(views, harness.context, harness.sink);
      ImGui::Render();
    }
  };
  const double azimuth = harness.surface.view.azimuth_rad;
  press(keys::kPad6);
  ASSERT_NE(harness.sink.Last<ViewDirectionCommand>(), nullptr);
  EXPECT_NEAR(harness.sink.Last<ViewDirectionCommand>()->azimuth_rad - azimuth,
              15 * std::numbers::pi / 180, 1e-12);
  for (int i = 0; i < 2; ++i) press(keys::kPadPlus);
  EXPECT_EQ(harness.surface.zoomed, 2);
}

/// The armchair and, beside it, a table; both selected.
void SelectBoth(AnnotateHarness& harness) {
  harness.view.also_selected = {"table_0"};
  ASSERT_EQ(harness.snapshot().selected, "armchair_0");
}

TEST(SeveralSelected, MoveAlongAsOneBodyAndAsOneEdit) {
  AnnotateHarness harness;
  SelectBoth(harness);
  const AnnotatedInstance& chair = *harness.snapshot().Find("armchair_0");
  const AnnotatedInstance& table = *harness.snapshot().Find("table_0");
  Eigen::Isometry3d turned = chair.scan_from_object;
  const Eigen::Vector3d up = harness.snapshot().level_from_scan.linear().row(2);
  turned.linear() = Eigen::AngleAxisd(0.3, up).toRotationMatrix() * turned.linear();
  turned.translation() += Eigen::Vector3d(0.1, 0, 0);
  const PendingPose pending = OnItsWay(harness.context, chair, turned);
  ASSERT_NE(pending.Find("table_0"), nullptr);
  const Eigen::Isometry3d before = chair.scan_from_object.inverse() * table.scan_from_object;
  const Eigen::Isometry3d after = turned.inverse() * *pending.Find("table_0");
  EXPECT_TRUE(before.isApprox(after, 1e-9)) << "they stand to each other as before";
  EXPECT_EQ(EditOf(pending).and_also.size(), 1u);
  Eigen::Isometry3d tilted = chair.scan_from_object;
  tilted.linear() =
      Eigen::AngleAxisd(0.1, up.unitOrthogonal()).toRotationMatrix() * tilted.linear();
  EXPECT_EQ(OnItsWay(harness.context, chair, tilted).Find("table_0"), nullptr)
      << "what stands upright does not tilt along";
}

TEST(SeveralSelected, WhatIsLockedStays) {
  AnnotateHarness harness;
  SelectBoth(harness);
  for (AnnotatedInstance& instance : harness.snapshot().instances)
    instance.locked = instance.id == "table_0";
  const AnnotatedInstance& chair = *harness.snapshot().Find("armchair_0");
  EXPECT_EQ(OnItsWay(harness.context, chair, At(3)).Find("table_0"), nullptr);
}

TEST(SeveralSelected, GoOntoTheFloorEachByItself) {
  AnnotateHarness harness;
  SelectBoth(harness);
  const Eigen::Isometry3d scan_from_level = harness.snapshot().level_from_scan.inverse();
  double height_m = 0.1;
  for (AnnotatedInstance& instance : harness.snapshot().instances) {
    Eigen::Isometry3d pose = harness.snapshot().level_from_scan * instance.scan_from_object;
    pose.translation().z() = height_m;
    instance.scan_from_object = scan_from_level * pose;
    height_m += 0.2;
  }
  harness.Press(keys::kG);
  const auto* edit = harness.sink.Last<SetInstancePoseCommand>();
  ASSERT_NE(edit, nullptr);
  ASSERT_EQ(edit->and_also.size(), 1u);
  const Eigen::Isometry3d& level_from_scan = harness.snapshot().level_from_scan;
  EXPECT_NEAR((level_from_scan * edit->scan_from_object).translation().z(), 0, 1e-9);
  EXPECT_NEAR((level_from_scan * edit->and_also[0].scan_from_object).translation().z(), 0, 1e-9);
}

TEST(SeveralSelected, TheirCopiesAreSelectedTogether) {
  AnnotateHarness harness;
  SelectBoth(harness);
  harness.Press(keys::kD, true);
  const auto* edit = harness.sink.Last<DuplicateInstanceCommand>();
  ASSERT_NE(edit, nullptr);
  EXPECT_EQ(edit->and_also, std::vector<std::string>{"table_0"});
  const AnnotationSnapshot before = harness.snapshot();
  for (const char* id : {"armchair_1", "table_1"}) {
    harness.snapshot().instances.push_back(before.instances.front());
    harness.snapshot().instances.back().id = id;
  }
  harness.snapshot().selected = "armchair_1";
  FollowSnapshot(before, harness.snapshot(), harness.view);
  EXPECT_EQ(harness.view.also_selected, std::vector<std::string>{"table_1"});
}

}  // namespace
}  // namespace plumbline
