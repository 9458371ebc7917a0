// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_actions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/ui/annotate_harness.h"
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
  EXPECT_EQ(harness.sink.Last<RefineByImagesCommand>()->id, "armchair_0");
  harness.Press(keys::kZ, true);
  EXPECT_NE(harness.sink.Last<UndoCommand>(), nullptr);
  harness.Press(keys::kZ, true, true);
  EXPECT_NE(harness.sink.Last<RedoCommand>(), nullptr);
  harness.snapshot().read_only = true;
  harness.sink.commands.clear();
  harness.Press(keys::kDelete);
  EXPECT_TRUE(harness.sink.commands.empty());
}

}  // namespace
}  // namespace plumbline
