// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "engine/mapping/map_report.h"
#include "engine/snapshot/truths_view.h"
#include "tests/ui/panel_harness.h"
#include "ui/inspect/panel_table.h"
#include "ui/inspect/timeline/timeline_lanes.h"

namespace plumbline {
namespace {

using Kind = TruthLane::Span::Kind;

/// Ten frames: boxed from the third, tentative from the fourth and confirmed from the seventh on;
/// out of sight in the last two.
RunHistory Ten() {
  RunHistory history;
  for (int i = 0; i < 10; ++i) {
    FrameSample frame;
    frame.frame = 2 * i;
    TruthSample truth;
    truth.visible_px = i < 8 ? 900.0f : 0.0f;
    truth.box = {20, 20, 60, 50};
    if (i >= 2) truth.box_fate = ProposalFate::kExplained;
    if (i >= 3) truth.object = {5};
    truth.confirmed = i >= 6;
    frame.truths = {TruthSample(), truth};
    history.frames.push_back(std::make_shared<const FrameSample>(frame));
  }
  return history;
}

/// "sofa" was found, "chair_B" was not.
std::shared_ptr<const TruthsView> OneMissed() {
  auto truths = std::make_shared<TruthsView>();
  truths->truths.resize(2);
  truths->truths[0].id = "sofa";
  truths->truths[0].found = true;
  TruthView& missed = truths->truths[1];
  missed.id = "chair_B";
  missed.model = "stool";
  missed.cause = MissedCause::kWithdrawn;
  missed.text = "Withdrawn: object 5 came within 4 cm";
  missed.frames = 10;
  missed.frames_seen = 8;
  missed.first_seen = 4;
  missed.best_frame = 6;
  missed.last_seen = 14;
  missed.boxes = {{ProposalFate::kExplained, {5}, 8}};
  NearCandidate candidate;
  candidate.object = {5};
  candidate.nearest_frame = 12;
  candidate.ended = 17;
  candidate.end = "tentative for too long";
  missed.candidates = {candidate};
  truths->found = truths->missed = 1;
  return truths;
}

PlaybackView WithHistory(const PlaybackView& playback) {
  PlaybackView with = playback;
  with.history = std::make_shared<const RunHistory>(Ten());
  return with;
}

TEST(TruthLane, JoinsWhatFollowsOneAnother) {
  const TruthLane lane = TruthLaneOf(Ten(), "chair_B", 1);
  ASSERT_EQ(lane.spans.size(), 4u);
  EXPECT_EQ(lane.spans[0].kind, Kind::kSeen);
  EXPECT_EQ(lane.spans[0].to, 14);
  EXPECT_EQ(lane.spans[1].kind, Kind::kBoxed);
  EXPECT_EQ(lane.spans[1].from, 4);
  EXPECT_EQ(lane.spans[2].kind, Kind::kTentative);
  EXPECT_EQ(lane.spans[2].object, ObjectId{5});
  EXPECT_EQ(lane.spans[2].to, 10);
  EXPECT_EQ(lane.spans[3].kind, Kind::kConfirmed);
  EXPECT_EQ(lane.spans[3].from, 12);
  EXPECT_EQ(lane.spans[3].to, 18);
  EXPECT_TRUE(TruthLaneOf(Ten(), "nobody", 7).spans.empty());
}

TEST(ObjectsPanel, ListsWhatWasMissedAndSelectsIt) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("objects");
  harness.size = {900, 260};
  harness.ShowFrame(12);
  harness.Draw(*panel, 2);
  EXPECT_EQ(harness.widgets.Find("objects.truth.chair_B"), nullptr);
  EXPECT_EQ(harness.widgets.Find("objects.missed"), nullptr);
  harness.context.truths = OneMissed();
  harness.Draw(*panel, 2);
  EXPECT_NE(harness.widgets.Find("objects.row.1"), nullptr) << "objects come first";
  harness.Click(*panel, "objects.missed");
  EXPECT_EQ(harness.widgets.Find("objects.row.1"), nullptr);
  harness.Click(*panel, "objects.truth.chair_B");
  EXPECT_EQ(harness.widgets.Find("objects.truth.sofa"), nullptr) << "it was found";
  ASSERT_NE(harness.sink.Last<SelectTruthCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectTruthCommand>()->truth, "chair_B");
  ASSERT_NE(harness.sink.Last<ShowPanelCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ShowPanelCommand>()->panel, "why");
}

TEST(WhyPanel, ExplainsATrueInstance) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("why");
  harness.size = {980, 300};
  harness.ShowFrame(12);
  harness.context.truths = OneMissed();
  harness.context.selection.truth = "chair_B";
  harness.Draw(*panel, 3);
  ASSERT_NE(harness.sink.Last<ProbeCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ProbeCommand>()->truth, "chair_B");
  harness.Click(*panel, "missed.best");
  EXPECT_EQ(harness.sink.Last<SeekCommand>()->frame, 6);
  harness.Click(*panel, "missed.candidate.5");
  EXPECT_EQ(harness.sink.Last<SeekCommand>()->frame, 12) << "where it was nearest";
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>()->object, ObjectId{5});
  harness.Click(*panel, "missed.plant");
  ASSERT_NE(harness.sink.Last<ForkCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ForkCommand>()->plant, "chair_B");
  EXPECT_EQ(harness.sink.Last<ForkCommand>()->frame, 3) << "before it first shows";
}

TEST(TimelinePanel, HasALaneForWhatWasMissed) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("timeline");
  harness.size = {1200, 300};
  harness.ShowFrame(12);
  harness.context.playback =
      std::make_shared<const PlaybackView>(WithHistory(*harness.context.playback));
  harness.context.truths = OneMissed();
  harness.Draw(*panel, 2);
  ASSERT_NE(harness.widgets.Find("timeline.truth.chair_B"), nullptr);
  EXPECT_EQ(harness.widgets.Find("timeline.truth.sofa"), nullptr);
  harness.Click(*panel, "timeline.truth.chair_B", 0.3f);
  ASSERT_NE(harness.sink.Last<SelectTruthCommand>(), nullptr);
  harness.Click(*panel, "timeline.truth");
  harness.Draw(*panel, 2);
  EXPECT_NE(harness.widgets.Find("timeline.truth.sofa"), nullptr) << "all of them";
}

TEST(ImagePanel, ShowsTheTruthAndSelectsIt) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("image");
  harness.size = {1000, 500};
  harness.ShowFrame(12);
  harness.context.playback =
      std::make_shared<const PlaybackView>(WithHistory(*harness.context.playback));
  harness.context.truths = OneMissed();
  harness.Draw(*panel, 2);
  EXPECT_EQ(harness.widgets.Find("image.truth.chair_B"), nullptr) << "not asked for";
  panel->LoadState({{"truth", true}});
  harness.Draw(*panel, 2);
  ASSERT_NE(harness.widgets.Find("image.truth.chair_B"), nullptr);
  panel->LoadState({{"truth", false}});
  harness.context.selection.truth = "chair_B";
  harness.Draw(*panel, 2);
  EXPECT_NE(harness.widgets.Find("image.truth.chair_B"), nullptr) << "what is selected shows";
}

}  // namespace
}  // namespace plumbline
