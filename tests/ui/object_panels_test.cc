// SPDX-License-Identifier: Apache-2.0
// Panels about one object, its particles and what might have become of it, on made-up frames.

#include <gtest/gtest.h>

#include "engine/mapping/particle_rank.h"
#include "engine/snapshot/map_snapshot.h"
#include "tests/ui/panel_harness.h"
#include "ui/inspect/panel_table.h"

namespace plumbline {
namespace {

TEST(ParticlesPanel, MarksTheParticleUnderTheMouse) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("particles");
  harness.ShowFrame(30);
  harness.context.selection.object = {1};
  harness.Click(*panel, "particles.view", 0.02f, 0.02f);
  ASSERT_NE(harness.sink.Last<SelectParticleCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectParticleCommand>()->particle, -1);
}

/// A mode where the object is.
PoseMode ModeOf(const ObjectReport& object, double weight) {
  PoseMode mode;
  mode.label = object.label;
  mode.world_from_object = object.world_from_object;
  mode.weight = weight;
  return mode;
}

TEST(DetailsPanel, ListsTheModesAndGoesToTheOneThatIsClicked) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("details");
  harness.ShowFrame(30);
  MapSnapshot snapshot = *harness.context.snapshot;
  ObjectReport& object = snapshot.report.objects[0];
  object.modes = {ModeOf(object, 0.7), ModeOf(object, 0.3)};
  object.modes[1].world_from_object.translation().x() += 1;
  object.particles = nullptr;
  harness.context.snapshot = std::make_shared<const MapSnapshot>(snapshot);
  harness.context.selection.object = object.id;
  harness.Analyse();
  const ObjectSpread* spread = harness.context.SpreadOf(object.id);
  ASSERT_NE(spread, nullptr);
  EXPECT_GT(spread->position_std_m, 0.45) << "not only the heaviest mode's";
  harness.Click(*panel, "details.mode.1");
  ASSERT_NE(harness.sink.Last<FocusModeCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<FocusModeCommand>()->mode, 1);
}

TEST(DetailsPanel, SaysWhetherSomeOfTheBeliefIsInNoMode) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("details");
  harness.ShowFrame(30);
  MapSnapshot snapshot = *harness.context.snapshot;
  ObjectReport& object = snapshot.report.objects[0];
  harness.context.selection.object = object.id;
  for (const double weight : {0.84, 0.99}) {
    object.modes = {ModeOf(object, weight)};
    harness.context.snapshot = std::make_shared<const MapSnapshot>(snapshot);
    harness.Analyse();
    harness.Draw(*panel, 2);
    EXPECT_EQ(harness.widgets.Find("details.elsewhere") != nullptr, weight < 0.9) << weight;
  }
}

TEST(RelationsPanel, AsksForRelationsAndShowsThem) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("relations");
  harness.ShowFrame(40);
  harness.Draw(*panel, 2);
  ASSERT_NE(harness.sink.Last<NeedCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<NeedCommand>()->what, NeedCommand::What::kRelations);
  EXPECT_EQ(harness.widgets.Find("relations.row.0"), nullptr) << "nothing is worked out here";
  harness.Analyse();
  ASSERT_FALSE(harness.context.analysis->relations->empty());
  harness.Click(*panel, "relations.row.0");
  ASSERT_NE(harness.sink.Last<SelectObjectCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectObjectCommand>()->object,
            harness.context.analysis->relations->front().a);
}

TEST(WhyPanel, AsksOnceAndSelectsAHypothesis) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("why");
  harness.size = {900, 220};
  harness.ShowFrame(30);
  harness.context.selection.object = {1};
  harness.Draw(*panel, 4);
  ASSERT_EQ(harness.sink.commands.size(), 1u);
  EXPECT_EQ(harness.sink.Last<ProbeCommand>()->object, ObjectId{1});
  auto probe = std::make_shared<ProbeView>();
  probe->frame = harness.context.snapshot->report.frame;
  probe->object = {1};
  probe->beta = 10;
  probe->verdict = Verdict::kSearch;
  probe->verdict_text = "Search: no particle is near.";
  probe->hypotheses.resize(2);
  probe->hypotheses[0].name = "mean";
  probe->hypotheses[1].name = "truth";
  probe->slices = {{"azimuth", "\u00b0", {-180, 0, 180}, {0, 0, 0}, {0, 1, 0}, {0, 10, 0}, {}, {}}};
  harness.context.probe = probe;
  harness.Click(*panel, "why.row.1");
  ASSERT_NE(harness.sink.Last<SelectHypothesisCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectHypothesisCommand>()->hypothesis, 1);
  harness.Point(*panel, "why.slice.azimuth");
}

TEST(WhatIfPanel, ShowsHowFarAForkIsAndStopsIt) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("what_if");
  harness.size = {700, 200};
  harness.ShowFrame(30);
  harness.Click(*panel, "what_if.options");
  EXPECT_NE(harness.sink.Last<AskOptionsCommand>(), nullptr);
  harness.Click(*panel, "what_if.fork");
  EXPECT_NE(harness.sink.Last<AskForkCommand>(), nullptr);
  EXPECT_EQ(harness.widgets.Find("what_if.progress"), nullptr);
  harness.context.fork = std::make_shared<const ForkView>(
      ForkView{ForkState::kRunning, "fork.plb", "Mapping the fork", 30, 90});
  harness.Click(*panel, "what_if.stop");
  EXPECT_NE(harness.widgets.Find("what_if.progress"), nullptr);
  EXPECT_NE(harness.sink.Last<CancelForkCommand>(), nullptr);
  PlaybackView recorded = *harness.context.playback;
  recorded.recorded = true;
  harness.context.playback = std::make_shared<const PlaybackView>(recorded);
  harness.Draw(*panel, 2);
  EXPECT_EQ(harness.widgets.Find("what_if.options"), nullptr) << "what is recorded keeps its own";
}

TEST(PosteriorPanel, DrawsAHistogramForEachParameter) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("posterior");
  harness.size = {900, 240};
  harness.ShowFrame(30);
  harness.context.selection.object = {1};
  harness.Draw(*panel, 2);
  for (const char* axis : {"0", "1", "2", "3"})
    EXPECT_NE(harness.widgets.Find(std::string("posterior.axis.") + axis), nullptr) << axis;
}

TEST(PosteriorPanel, ShowsShapesOverTimeAndGoesToTheFrameThatIsClicked) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("posterior");
  harness.size = {900, 240};
  harness.ShowFrame(30);
  harness.context.selection.object = {2};
  harness.Click(*panel, "posterior.shapes");
  EXPECT_EQ(panel->SaveState()["shapes"], true);
  EXPECT_EQ(harness.widgets.Find("posterior.labels"), nullptr) << "nothing is read yet";
  PlaybackView playback = *harness.context.playback;
  auto history = std::make_shared<RunHistory>();
  for (int i = 10; i < 40; ++i) {
    auto frame = std::make_shared<FrameSample>();
    frame->frame = i;
    frame->objects.resize(1);
    frame->objects[0].id = {2};
    frame->objects[0].label_probability = {{{0}, 0.9}, {{1}, 0.1}};
    history->frames.push_back(frame);
  }
  playback.history = history;
  harness.context.playback = std::make_shared<const PlaybackView>(playback);
  harness.Analyse();
  harness.Click(*panel, "posterior.labels", 0.5f, 0.5f);
  ASSERT_NE(harness.sink.Last<SeekCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SeekCommand>()->frame, 25);
}

/// Frame 30 with object 2 selected, of which nothing is known yet.
std::shared_ptr<ObjectHistory> ShowObject2(PanelHarness& harness) {
  harness.size = {900, 240};
  harness.ShowFrame(30);
  harness.context.selection.object = {2};
  auto history = std::make_shared<ObjectHistory>();
  history->object = {2};
  return history;
}

TEST(PosteriorPanel, ShowsHowReliableTheRunIs) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("posterior");
  const auto history = ShowObject2(harness);
  Reliability& all = history->reliability.all;
  all.poses = 60;
  all.within_50 = 20;
  all.within_95 = 40;
  all.objects = 1;
  all.nees = 9;
  all.labels.Add(0.9, false);
  history->reliability.objects = {{{2}, all}};
  history->confirmation = {{{0.9, 1, 0.5}, {0.4, 0.5, 0.5}}, 0.5, 2};
  harness.context.history = history;
  harness.Click(*panel, "posterior.reliability");
  EXPECT_EQ(panel->SaveState()["reliability"], true);
  for (const char* name :
       {"posterior.reliability_table", "posterior.labels_diagram", "posterior.precision_recall"})
    EXPECT_NE(harness.widgets.Find(name), nullptr) << name;
  harness.Click(*panel, "posterior.shapes");
  EXPECT_EQ(panel->SaveState()["reliability"], false) << "one view at a time";
  harness.context.history = std::make_shared<ObjectHistory>();
  harness.Click(*panel, "posterior.reliability");
  harness.size = {400, 100};
  harness.Draw(*panel, 2);
  EXPECT_EQ(harness.widgets.Find("posterior.labels_diagram"), nullptr) << "no room";
}

TEST(PosteriorPanel, SaysWhetherBeliefsAreReliable) {
  struct {
    int within_50, within_95;
    double nees;
    const char* said;
  } const cases[] = {{20, 40, 4, "posterior.overconfident"},
                     {30, 57, 4, "posterior.calibrated"},
                     {55, 60, 4, "posterior.underconfident"},
                     {30, 57, 100, "posterior.one_overconfident"},
                     {55, 60, 100, "posterior.one_overconfident"}};
  for (const auto& is : cases) {
    PanelHarness harness;
    const auto panel = MakeInspectPanel("posterior");
    const auto history = ShowObject2(harness);
    Reliability& all = history->reliability.all;
    all.poses = 60;
    all.within_50 = is.within_50;
    all.within_95 = is.within_95;
    all.objects = 2;
    all.nees = is.nees;
    all.nees_high = 9;
    history->reliability.objects = {{{2}, all}, {{3}, all}};
    harness.context.history = history;
    harness.Draw(*panel, 2);
    EXPECT_NE(harness.widgets.Find(is.said), nullptr) << is.said;
  }
}

TEST(WhyPanel, SweepsTwoParametersAtOnce) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("why");
  harness.size = {900, 260};
  harness.ShowFrame(30);
  harness.context.selection.object = {1};
  harness.Click(*panel, "why.maps");
  harness.Draw(*panel, 2);
  ASSERT_NE(harness.sink.Last<ProbeCommand>(), nullptr);
  EXPECT_TRUE(harness.sink.Last<ProbeCommand>()->maps);
  auto probe = std::make_shared<ProbeView>();
  probe->frame = harness.context.snapshot->report.frame;
  probe->object = {1};
  probe->hypotheses.resize(1);
  probe->maps = {{"azimuth",
                  "\u00b0",
                  "distance",
                  "cm",
                  {-180, 0, 180},
                  {-5, 0, 5},
                  std::vector<float>(9),
                  std::vector<float>(9),
                  {0, 1, 2, 3, 4, 5, 6, 7, 8},
                  {}}};
  harness.context.probe = probe;
  harness.Point(*panel, "why.map.azimuth");
  harness.Click(*panel, "why.term.1");
  EXPECT_EQ(panel->SaveState()["term"], 1);
}

TEST(ParticlesPanel, AsksForTheOutlineOfTheParticleUnderTheMouse) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("particle_table");
  harness.size = {900, 300};
  harness.ShowFrame(30);
  harness.context.selection.object = {1};
  harness.Draw(*panel, 3);
  harness.Point(*panel, "particle_table.row.2");
  ASSERT_NE(harness.sink.Last<HoverParticleCommand>(), nullptr);
  EXPECT_GE(harness.sink.Last<HoverParticleCommand>()->particle, 0);
}

TEST(ParticleTablePanel, SortsAndMarks) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("particle_table");
  harness.size = {900, 300};
  harness.ShowFrame(30);
  harness.context.selection.object = {1};
  harness.Draw(*panel, 3);                           // columns find their places
  harness.Click(*panel, "particle_table.column.4");  // falling edge term
  harness.Click(*panel, "particle_table.row.0");
  ASSERT_NE(harness.sink.Last<SelectParticleCommand>(), nullptr);
  const int marked = harness.sink.Last<SelectParticleCommand>()->particle;
  const auto& particles = *harness.context.SelectedObject()->particles;
  for (const Particle& particle : particles)
    EXPECT_LE(particle.phi_edge, particles[static_cast<std::size_t>(marked)].phi_edge);
}

TEST(ParticleTablePanel, SortsByRank) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("particle_table");
  harness.size = {900, 300};
  harness.ShowFrame(30);
  harness.context.selection.object = {1};
  MapperOptions options;
  options.alpha = 0;
  options.beta = 1;
  harness.Analyse(options);
  harness.Draw(*panel, 3);
  const auto& particles = *harness.context.SelectedObject()->particles;
  const std::vector<int> order = ByRank(particles, 0, 1);
  harness.Click(*panel, "particle_table.column.1");  // falling: the worst first
  harness.Click(*panel, "particle_table.row.0");
  ASSERT_NE(harness.sink.Last<SelectParticleCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectParticleCommand>()->particle, order.back());
  harness.Click(*panel, "particle_table.column.1");  // rising
  harness.Click(*panel, "particle_table.row.0");
  EXPECT_EQ(harness.sink.Last<SelectParticleCommand>()->particle, order.front());
}

}  // namespace
}  // namespace plumbline
