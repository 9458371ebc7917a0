// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/film/render_layout.h"
#include "app/window/inspect/arrangements.h"
#include "app/window/inspect/bookmarks.h"
#include "app/window/inspect/image_views.h"
#include "app/window/inspect/looks_keeper.h"
#include "app/window/inspect/presenter.h"
#include "app/window/inspect/what_if.h"
#include "app/window/workspace.h"
#include "engine/runtime/batch_reader.h"
#include "engine/runtime/graph_process.h"
#include "engine/runtime/mapping_process.h"
#include "engine/runtime/network_process.h"
#include "ui/framework/scene_surface.h"
#include "ui/inspect/compare/batch_sheet.h"
#include "ui/inspect/compare/fork_sheet.h"
#include "ui/inspect/inspect_bar.h"
#include "ui/inspect/networks_sheet.h"
#include "ui/inspect/panel_table.h"

namespace plumbline {

/// What a sequence is opened with instead of what was chosen at the start; "" and nothing: as it
/// was.
struct OpenWith {
  std::string models;           ///< A folder; of runs, too.
  std::string edges, detector;  ///< As --edges and --detector name them.
  std::optional<MapperOptions> options;
  bool find_poses = false;  ///< By the visual-inertial filter.
};

struct InspectOptions {
  /// How to open a sequence or a run.
  std::function<MappingProcess::OpenSource(const std::string& path, const OpenWith& with)> opener;
  RunChoice inputs;                      ///< Where the sequence and the models of runs are now.
  std::string program_version;           ///< What forks say that they were made by.
  bool present = false;                  ///< Begins with the demo mode; its end is that of all.
  const RenderLayout* layout = nullptr;  ///< Shows these panels alone; null: the whole window.
  ObjectId select;                       ///< Selected at the start; not valid: one in view.
  std::filesystem::path settings;        ///< Of the window; bookmarks of sequences lie beside it.
  std::optional<GraphChoice> graph;      ///< That maps what is opened first; nothing: none.
};

/// Plays a sequence through the mapper, or a recorded run.
class InspectWorkspace : public Workspace {
 public:
  /// @param window  Where it puts what it asks of the window and of itself. Outlives it.
  /// @param wake    Called from other threads when there is something new to draw.
  InspectWorkspace(InspectOptions options, bool software_gl, FrameContext& context,
                   CommandSink& window, std::function<void()> wake);
  ~InspectWorkspace() override;

  WorkspaceTab tab() const override;
  const std::string& source() const override { return source_; }
  bool Takes(const std::string&) const override { return true; }  // and says what is wrong with it
  void UseModels(const std::string& folder) override;
  void Open(const std::string& path, std::optional<int> frame, FrameContext& context) override;
  /// Opens a second run beside the first.
  void Compare(const std::string& run, FrameContext& context);
  /// Says in the sheet of the networks what a file is.
  void LookAtNetwork(const std::string& file);
  /// Shows the sheet of a batch of runs: a folder or its results.
  void LookAtBatch(const std::string& path);
  void ReadSlots(FrameContext& context) override;
  bool IsOpen(const FrameContext& context) const override { return context.sequence != nullptr; }
  bool FillsWindow() const override { return presenter_.active() || is_figure(); }
  void Draw(FrameContext& context, const LayoutRect& rect, CommandSink& sink) override;
  void DrawBar(const FrameContext& context, const LayoutRect& rect, CommandSink& sink) override;
  bool DrawSheets(const FrameContext& context, CommandSink& sink) override;
  StatusLine status_line(const FrameContext& context) const override;
  const std::vector<ActionGroup>& actions() const override { return actions_; }
  void AddPaletteEntries(const FrameContext& context,
                         std::vector<PaletteEntry>& entries) const override;
  std::vector<PaletteEntry> AnswerPalette(const FrameContext& context,
                                          const std::string& query) const override;
  void Handle(const ViewCommand& command, FrameContext& context) override;
  void Handle(const InspectCommand& command, FrameContext& context);
  void Handle(const PlaybackCommand& command, FrameContext& context);
  bool Moves(const FrameContext& context) override;
  Pace pace(const FrameContext& context) const override;
  void AddState(const FrameContext& context, nlohmann::json& state) const override;
  void SaveSettings(const FrameContext& context, nlohmann::json& settings) const override;
  void LoadSettings(const nlohmann::json& settings, FrameContext& context) override;

 private:
  bool is_figure() const { return options_.layout != nullptr && !options_.layout->panels.empty(); }
  /// Those that stand in one place, in the table's order.
  std::vector<Panel*> PanelsAt(PanelPlace place) const;
  /// Those of them that are not hidden.
  std::vector<Panel*> ShownAt(const FrameContext& context, PanelPlace place) const;
  Panel& PanelAt(PanelPlace place) const { return *PanelsAt(place).front(); }
  void FocusTruth(const FrameContext& context);
  void SelectByItself(FrameContext& context) const;
  /// Asks the process for what the panels of the last frame of the window showed.
  void AskForWhatIsNeeded(const FrameContext& context);
  void DrawPanels(FrameContext& context, CommandSink& sink);
  void DrawMaximized(FrameContext& context, const InspectLayout& layout, CommandSink& sink);
  /// Tabs of which `front` is the number of the one in front among `all`.
  void DrawTabs(const FrameContext& context, const LayoutRect& rect, std::span<Panel* const> shown,
                std::span<Panel* const> all, std::size_t& front, CommandSink& sink) const;
  /// In a window without room for more: the tabs of all lists in one place.
  void DrawAllTabs(const FrameContext& context, const LayoutRect& rect, CommandSink& sink);
  void Arrange(const Arrangement& arrangement, FrameContext& context);
  void HidePanel(const HidePanelCommand& command, FrameContext& context) const;
  void FocusMode(int mode, FrameContext& context);
  /// The panels of options_.layout.
  void DrawFigure(const FrameContext& context, ImVec2 size, CommandSink& sink);
  void SelectParticle(int particle, FrameContext& context);
  void HoverParticle(int particle, FrameContext& context);
  void ShowPanel(const std::string& id);
  /// `process` is what is open from now on.
  /// Looks on at a graph that is mapping on this machine: at the run that its recorder writes.
  MappingProcess::OpenSource OpenGraph(const std::string& place);
  void Begin(std::unique_ptr<MappingProcess> process, FrameContext& context);
  /// Opens the sequence once more with other networks; what is open goes on until that is ready.
  void Reopen(const UseNetworksCommand& networks, const FrameContext& context);
  void TakeReopened(FrameContext& context);
  /// Why nothing could be opened, where the window knows a remedy.
  void LookForRemedy(FrameContext& context);
  void Present(bool on, FrameContext& context);
  void AddBookmarksRead(FrameContext& context);
  void KeepBookmarks(FrameContext& context);

  InspectOptions options_;
  CommandSink& window_;
  std::function<void()> wake_;
  std::string source_;
  OpenWith with_, reopened_with_;
  std::unique_ptr<SceneSurface> scene_;
  ImageViewport viewport_;
  LayoutRatios ratios_;
  std::vector<std::unique_ptr<Panel>> owned_;  ///< As in the table.
  std::vector<Panel*> panels_;                 ///< The same.
  std::vector<ActionGroup> actions_;
  std::unique_ptr<ImageViews> views_;
  std::size_t map_tab_ = 0, object_tab_ = 0;
  std::string compact_tab_ = "objects";  ///< In front, in a compact window.
  Arrangements arrangements_;
  LayoutMenu layout_menu_;
  ForkSheet fork_sheet_;
  NetworksSheet networks_sheet_;
  BatchSheet batch_sheet_;
  Presenter presenter_;
  bool quit_after_presenting_ = false;  ///< It was opened for that alone.
  ProbeCommand asked_;                  ///< The last question about an object.
  WatchCommand needed_, watched_;       ///< What panels showed in this frame; what was asked for.
  MappingProcess* watched_by_ = nullptr;
  LooksKeeper looks_;
  std::uint64_t remedy_sought_for_ = 0;  ///< The source_version.
  int hovered_now_ = -1;     ///< The particle that a panel of this frame saw under the mouse.
  bool auto_select_ = true;  ///< Until the user selects: an object that is in view.
  bool ask_frame_ = false;

  bool bookmarks_known_ = false;    ///< Those of what is open were read.
  bool bookmarks_changed_ = false;  ///< Before they were: they are written then.

  // Last: their threads wake the window.
  BookmarkKeeper bookmarks_;
  NetworkProcess networks_;
  BatchReader batches_;
  std::unique_ptr<WhatIf> what_if_;
  std::unique_ptr<GraphProcess> graph_;  ///< Null: none is told.
  std::string graph_source_;             ///< What it maps.
  std::unique_ptr<MappingProcess> process_;
  std::unique_ptr<MappingProcess> reopened_;  ///< Takes the place of `process_` once it is open.
};

}  // namespace plumbline
