// SPDX-License-Identifier: Apache-2.0
// The tables of panels and their actions: complete, and without contradictions.

#include "ui/inspect/panel_table.h"

#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "app/film/render_layout.h"
#include "tests/ui/panel_harness.h"
#include "ui/annotate/annotate_actions.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/common/palette.h"
#include "ui/common/window_actions.h"

namespace plumbline {
namespace {

std::vector<ActionGroup> With(std::vector<ActionGroup> groups) {
  groups.push_back(ViewActions());
  groups.push_back(WindowActions());
  return groups;
}

TEST(PanelTable, NamesEveryPanelOnce) {
  std::set<std::string> ids, titles;
  const auto check = [&](const PanelInfo& info) {
    EXPECT_TRUE(ids.insert(info.id).second) << info.id;
    EXPECT_TRUE(titles.insert(info.title).second) << info.title;
    EXPECT_FALSE(std::string(info.id).empty());
    EXPECT_FALSE(std::string(info.title).empty()) << info.id;
    EXPECT_TRUE(std::string(info.help).ends_with('.')) << info.id << ": a sentence for the tooltip";
  };
  for (const PanelEntry& entry : InspectPanels()) check(entry.info);
  for (const AnnotatePanelEntry& entry : AnnotatePanels()) check(entry.info);
}

TEST(PanelTable, FillsEveryPlaceOfTheWorkspace) {
  std::map<PanelPlace, int> count;
  for (const PanelEntry& entry : InspectPanels()) ++count[entry.place];
  EXPECT_EQ(count[PanelPlace::kImageView], 5);
  EXPECT_GE(count[PanelPlace::kAboutMap], 1);
  EXPECT_GE(count[PanelPlace::kAboutObject], 1);
  for (const PanelPlace one :
       {PanelPlace::kMap, PanelPlace::kTimings, PanelPlace::kTimeline, PanelPlace::kOtherRun})
    EXPECT_EQ(count[one], 1);
}

TEST(PanelTable, GivesEveryPanelItsName) {
  for (const PanelEntry& entry : InspectPanels()) {
    const auto panel = MakeInspectPanel(entry.info.id);
    ASSERT_NE(panel, nullptr);
    EXPECT_STREQ(panel->id(), entry.info.id);
  }
  EXPECT_EQ(MakeInspectPanel("no such panel"), nullptr);
  for (const AnnotatePanelEntry& entry : AnnotatePanels())
    EXPECT_STREQ(MakeAnnotatePanel(entry.info.id)->id(), entry.info.id);
}

TEST(PanelTable, HasEveryPanelThatAFigureNames) {
  for (const RenderLayout& layout : RenderLayouts()) {
    for (const PlacedPanel& placed : layout.panels)
      EXPECT_NE(MakeInspectPanel(placed.panel), nullptr) << layout.name << ": " << placed.panel;
    for (const auto& [id, state] : layout.states.items())
      EXPECT_NE(MakeInspectPanel(id), nullptr) << layout.name << ": " << id;
  }
}

TEST(Actions, DoNotShareAKeyWithinAWorkspace) {
  for (const auto& groups : {With(InspectActions()), With(AnnotateActions())}) {
    std::map<KeyStroke, std::string> taken;
    for (const ActionGroup& group : groups) {
      for (const Action& action : group.actions) {
        for (const KeyStroke& stroke : action.keys) {
          const auto [at, is_new] = taken.try_emplace(stroke, group.title);
          EXPECT_TRUE(is_new) << NameOf(stroke) << " is in " << at->second << " and "
                              << group.title;
        }
      }
    }
  }
}

TEST(Actions, AreToldOfWhereTheyCanBeFound) {
  for (const auto& groups : {With(InspectActions()), With(AnnotateActions())}) {
    for (const ActionGroup& group : groups) {
      EXPECT_FALSE(group.title.empty());
      bool row = false;
      for (const Action& action : group.actions) {
        row = row || !action.help.empty();
        EXPECT_EQ(action.help.empty(), action.help_keys.empty()) << group.title;
        EXPECT_TRUE(row || action.keys.empty())
            << group.title << ": the help sheet has no row for a key of " << action.text;
        EXPECT_FALSE(action.keys.empty() && action.text.empty())
            << group.title << ": neither a key nor a name";
        EXPECT_EQ(action.text_when_on.empty(), !action.is_on) << action.text;
        EXPECT_TRUE(action.run || !action.keys.empty()) << group.title;
      }
    }
  }
}

TEST(Actions, RunFromTheirKeysAndFromThePalette) {
  PanelHarness harness;
  harness.ShowFrame(20);
  const std::vector<ActionGroup> groups = With(InspectActions());
  ImGuiIO& io = ImGui::GetIO();
  const auto strike = [&](const KeyStroke& stroke) {
    io.KeyShift = stroke.shift;
    io.KeyCtrl = stroke.control;
    for (const bool down : {true, false}) {
      io.KeysDown[stroke.key] = down;
      ImGui::NewFrame();
      RunKeys(groups, harness.context, harness.sink);
      ImGui::Render();
    }
  };
  strike({keys::kRight, true});
  ASSERT_NE(harness.sink.Last<StepCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<StepCommand>()->frames, 10);
  strike({keys::kV});
  EXPECT_EQ(harness.sink.Last<ShowRunCommand>(), nullptr) << "there is no second run";
  for (const PaletteEntry& entry : EntriesOf(groups, harness.context)) {
    if (entry.text == "Show panel: Belief") entry.run(harness.sink);
    EXPECT_NE(entry.text, "Two runs: blink");
  }
  ASSERT_NE(harness.sink.Last<ShowPanelCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ShowPanelCommand>()->panel, "posterior");
}

}  // namespace
}  // namespace plumbline
