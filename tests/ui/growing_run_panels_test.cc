// SPDX-License-Identifier: Apache-2.0
// What the window shows of a run that somebody else is mapping, and of the processes that map it.
#include <algorithm>

#include <gmock/gmock.h>

#include "tests/ui/panel_harness.h"
#include "ui/inspect/inspect_bar.h"
#include "ui/inspect/panel_table.h"

namespace plumbline {
namespace {

TEST(StatusBar, SaysThatARunIsStillBeingMapped) {
  PanelHarness harness;
  harness.ShowFrame(20);
  PlaybackView playback = *harness.context.playback;
  playback.recorded = playback.growing = playback.follow = true;
  playback.state = PlaybackState::kPlaying;
  playback.newest_mapped_frame = 20;
  const auto status = [&] {
    harness.context.playback = std::make_shared<const PlaybackView>(playback);
    return InspectStatus(harness.context).text;
  };
  EXPECT_THAT(status(), testing::StartsWith("Following the run as it is mapped: frame 20"));
  playback.follow = false;
  playback.newest_mapped_frame = 31;
  playback.state = PlaybackState::kPaused;
  EXPECT_EQ(status(),
            "Looking back at frame 20; the run is mapped up to 31, and goes on. N shows the "
            "newest.");
}

TEST(TimelinePanel, LetsOneGoBackToTheNewestFrameOfARunThatIsBeingMapped) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("timeline");
  harness.size = {900, 90};
  harness.ShowFrame(20);
  PlaybackView playback = *harness.context.playback;
  playback.recorded = true;
  harness.context.playback = std::make_shared<const PlaybackView>(playback);
  harness.Draw(*panel, 2);
  EXPECT_EQ(harness.widgets.Find("timeline.live"), nullptr) << "nothing comes of a finished run";
  playback.growing = true;
  harness.context.playback = std::make_shared<const PlaybackView>(playback);
  harness.Click(*panel, "timeline.live");
  ASSERT_NE(harness.sink.Last<FollowNewestCommand>(), nullptr);
  EXPECT_TRUE(harness.sink.Last<FollowNewestCommand>()->on);
}

TEST(ProcessesPanel, ShowsEveryNodeWhetherItAnswersOrNot) {
  PanelHarness harness;
  harness.size = {560, 260};
  harness.ShowFrame(20);
  const auto panel = MakeInspectPanel("processes");
  const auto entry = std::find_if(InspectPanels().begin(), InspectPanels().end(),
                                  [&](const PanelEntry& e) { return panel->id() == e.info.id; });
  EXPECT_FALSE(entry->is_there(harness.context)) << "of a run that no graph maps";
  auto graph = std::make_shared<GraphView>();
  graph->name = "graph";
  graph->nodes.resize(3);
  graph->nodes[0] = {.name = "player", .kind = "player", .answers = true, .state = "played 20"};
  graph->nodes[0].streams = {{"images", 20, 0, 4.1, 3.2}};
  graph->nodes[1] = {.name = "detector", .kind = "detector", .answers = true, .restarts = 2};
  graph->nodes[1].streams = {{"proposals", 20, 0, 4.1, 83}, {"scores", 900, 0, 180, 4}};
  graph->nodes[1].clock_ahead_ms = -12.5;
  graph->nodes[1].peers = {{.name = "player", .requests = 22, .open = 2, .asked_again = 1}};
  graph->nodes[2] = {.name = "mapper", .kind = "mapper"};
  graph->nodes[2].streams = {{"map", 18, 3, 3.9, 340}};
  harness.context.graph = graph;
  EXPECT_TRUE(entry->is_there(harness.context));
  harness.Draw(*panel, 3);
  for (const char* name : {"processes.player", "processes.detector", "processes.mapper"})
    EXPECT_NE(harness.widgets.Find(name), nullptr) << name;
  graph->problem = "the key of 'viewer' is missing";
  harness.Draw(*panel, 3);
  EXPECT_EQ(harness.widgets.Find("processes.player"), nullptr);
}

}  // namespace
}  // namespace plumbline
