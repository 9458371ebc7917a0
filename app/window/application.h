// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/film/render_layout.h"
#include "app/platform/imgui_backend.h"
#include "app/platform/window.h"
#include "app/window/annotate/annotate_workspace.h"
#include "app/window/inspect/image_views.h"
#include "app/window/inspect/presenter.h"
#include "app/window/inspect/what_if.h"
#include "app/window/ui_script.h"
#include "engine/runtime/mapping_process.h"
#include "engine/snapshot/commands.h"
#include "ui/common/palette.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/gl_texture_store.h"
#include "ui/framework/layout.h"
#include "ui/framework/panel.h"
#include "ui/framework/scene_surface.h"
#include "ui/inspect/compare/fork_sheet.h"

namespace plumbline {

struct ApplicationOptions {
  /// How to open a path that the user names, on the command line or by dropping it onto the window.
  /// `models`: a folder of models instead of those chosen at the start; "": none.
  std::function<MappingProcess::OpenSource(const std::string& path, const std::string& models)>
      opener;
  AnnotationChoice annotation;  ///< What is opened as a scan is opened with these models.
  std::string path;             ///< To open at the start; "": none.
  std::string compare;          ///< A second run to open beside it; "": none.
  RunChoice inputs;             ///< Where the sequence and the models of runs are now.
  std::string program_version;  ///< What forks say that they were made by.
  std::optional<int> start_frame;
  bool present = false;                  ///< Begins with the demo mode; its end is that of all.
  bool play = false;                     ///< Plays once it is open.
  const RenderLayout* layout = nullptr;  ///< Shows these panels alone; null: the whole window.
  bool light = false;                    ///< Theme, unless the settings say otherwise.
  ObjectId select;                       ///< Selected at the start; not valid: one in view.
  bool ignore_pointer = false;  ///< Nobody holds the mouse: a film must not show its tooltips.
  int width = 1600, height = 1000;
  std::optional<double> ui_scale;    ///< Else as the desktop wishes, or as it was left.
  std::filesystem::path settings;    ///< Where layout and switches are kept; empty: nowhere.
  std::filesystem::path script;      ///< Drives the window and ends it; empty: the user does.
  std::filesystem::path state_file;  ///< Gets State() whenever it has changed; empty: none. For
                                     ///< tests with real input.
};

/// Owns the window, the panels, the process that feeds them, and the settings; runs the frame loop.
/// The main thread only: all drawing happens here, and nothing here waits for the engine.
class Application : private CommandSink {
 public:
  static Result<std::unique_ptr<Application>> Create(ApplicationOptions options);
  ~Application() override;

  /// Until the window is closed or the script ends. Errors: of the script.
  Status Run();
  /// One turn of the loop without waiting for events: draws the newest state; the picture, if asked
  /// for.
  void DrawFrame(cv::Mat* picture = nullptr);
  MappingProcess* process() { return process_.get(); }
  const FrameContext& context() const { return context_; }
  /// For scripts and tests.
  nlohmann::json State() const;

 private:
  Application(ApplicationOptions options, std::unique_ptr<PlatformWindow> window);

  void Send(Command command) override;
  void Handle(const WindowCommand& command);
  void Open(const std::string& path, std::optional<int> frame);
  /// A folder of models was dropped: what is open is opened again with them.
  void OpenModels(const std::string& folder);
  void ReadSlots();
  void SelectByItself();
  void DrawWindow();
  void DrawInspect(const InspectLayout& layout);
  /// The demo mode, instead of everything else.
  void DrawPresentation(ImVec2 size);
  void Present(bool on);
  /// Null while Inspect, which is this class itself, shows.
  Workspace* shown() {
    return context_.workspace == WorkspaceId::kAnnotate ? annotate_.get() : nullptr;
  }
  void DrawPanels(const InspectLayout& layout);
  /// The panels of options_.layout.
  void DrawFigure(ImVec2 size);
  void Remember(const std::string& path);
  void HoverParticle(int particle);
  void KeepBookmarks();
  void SetUiScale(double scale);
  void LoadSettings();
  void SaveSettings() const;
  /// The name of the file that was written.
  Result<std::string> SaveScreenshot(const std::string& file, const std::string& of = "");
  void WriteStateFile();
  bool NeedsFrame();
  void Note(std::string text);

  ApplicationOptions options_;
  std::unique_ptr<PlatformWindow> window_;
  std::unique_ptr<ImGuiBackend> backend_;
  std::unique_ptr<GlTextureStore> textures_;
  std::unique_ptr<SceneSurface> scene_;
  WidgetLog widgets_;
  ImageViewport viewport_;
  LayoutRatios ratios_;
  FrameContext context_;
  std::unique_ptr<Panel> image_, edges_, depth_, masks_, particles_, map_, objects_, relations_,
      details_, timings_, timeline_, why_, particle_table_, posterior_, flow_, what_if_panel_,
      other_image_;
  std::size_t details_tab_ = 0, objects_tab_ = 0;
  std::vector<Panel*> panels_;
  std::unique_ptr<ImageViews> views_;
  std::optional<UiScript> script_;
  UiScript::Host script_host_;
  Status script_status_;

  std::string models_;       ///< Dropped onto the window; "": none.
  ProbeCommand asked_;       ///< The last question about an object.
  int hovered_now_ = -1;     ///< The particle that a panel of this frame saw under the mouse.
  bool auto_select_ = true;  ///< Until the user selects: an object that is in view.
  bool show_help_ = false;
  PaletteState palette_;
  ForkSheet fork_sheet_;
  Presenter presenter_;
  bool quit_ = false;
  bool quit_after_presenting_ = false;  ///< It was opened for that alone.
  bool wanted_ask_frame_ = false;
  std::optional<double> wanted_scale_;
  std::optional<std::string> wanted_path_;
  std::optional<ScreenshotCommand> wanted_screenshot_;
  int screenshot_in_ = 0;  ///< Frames until it is taken: menus and tooltips go first.
  std::string note_, written_state_;
  std::chrono::steady_clock::time_point note_until_{};
  int settle_frames_ = 0;  ///< Frames to draw after the last input until ImGui has come to rest.
  std::atomic<bool> published_ = false;

  // Last: their threads wake the window.
  std::unique_ptr<AnnotateWorkspace> annotate_;
  std::unique_ptr<WhatIf> what_if_;
  std::unique_ptr<MappingProcess> process_;
};

/// Where settings of the window are kept: `$XDG_CONFIG_HOME/plumbline/window.json` or below
/// `~/.config`.
std::filesystem::path DefaultSettingsFile();

}  // namespace plumbline
