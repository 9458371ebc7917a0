// SPDX-License-Identifier: Apache-2.0
// What panels keep in the window's settings; only where the window is built.
#include <array>

#include "engine/snapshot/map_snapshot.h"
#include "tests/fuzz/fuzz_targets.h"
#include "tests/ui/panel_harness.h"
#include "ui/files/kept_value.h"
#include "ui/files/window_settings.h"
#include "ui/inspect/panel_table.h"

namespace plumbline::fuzz {
namespace {

/// Every panel of Inspect takes its state from the settings and is drawn with it.
Status PanelStates(std::string_view input) {
  static PanelHarness harness;
  if (harness.context.source.empty()) {
    harness.ShowFrame(20);
    harness.context.source = "room.plb";
    harness.context.selection.object = harness.context.snapshot->report.objects.front().id;
  }
  const auto panels = KeptObject(ReadSettings(FileOf("window.json", input)), "panels");
  for (const PanelEntry& entry : InspectPanels()) {
    const auto panel = MakePanel(entry);
    panel->LoadState(KeptObject(panels, panel->id()));
    harness.Draw(*panel);
    (void)panel->SaveState();
  }
  harness.sink.commands.clear();
  return {};
}

constexpr std::array kPanelTargets = {Target{"panel_states", PanelStates}};

}  // namespace

std::span<const Target> PanelTargets() { return kPanelTargets; }

}  // namespace plumbline::fuzz
