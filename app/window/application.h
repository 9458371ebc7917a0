// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/platform/imgui_backend.h"
#include "app/platform/window.h"
#include "app/window/annotate/annotate_workspace.h"
#include "app/window/inspect/inspect_workspace.h"
#include "app/window/ui_script.h"
#include "engine/runtime/folder_reader.h"
#include "engine/runtime/running_graph.h"
#include "engine/snapshot/commands.h"
#include "ui/common/palette.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/gl_texture_store.h"
#include "ui/framework/path_dialog.h"

namespace plumbline {

struct ApplicationOptions {
  InspectOptions inspect;       ///< `settings` is taken from below.
  AnnotationChoice annotation;  ///< What is opened as a scan is opened with these models.
  std::string path;             ///< To open at the start; "": none.
  std::string compare;          ///< A second run to open beside it; "": none.
  std::optional<int> start_frame;
  bool play = false;            ///< Plays once it is open.
  bool light = false;           ///< Theme, unless the settings say otherwise.
  bool ignore_pointer = false;  ///< Nobody holds the mouse: a film must not show its tooltips.
  int width = 1600, height = 1000;
  std::optional<double> ui_scale;  ///< Else as the desktop wishes, or as it was left.
  std::filesystem::path settings;  ///< Where layout and switches are kept; empty: nowhere.
  std::filesystem::path script;    ///< Drives the window and ends it; empty: the user does.
  // For tests with real input:
  std::filesystem::path state_file;  ///< Gets State() whenever it has changed; empty: none.
  double least_frame_ms = 0;         ///< A frame takes at least so long, as on a slow machine.
};

/// Owns the window, its workspaces and the settings, and runs the frame loop. The main thread only:
/// all drawing happens here, and nothing here waits for the engine.
class Application : public CommandSink {
 public:
  static Result<std::unique_ptr<Application>> Create(ApplicationOptions options);
  ~Application() override;

  /// Until the window is closed or the script ends. Errors: of the script.
  Status Run();
  /// One turn of the loop without waiting for events: draws the newest state; the picture, if asked
  /// for.
  void DrawFrame(cv::Mat* picture = nullptr);
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
  std::array<Workspace*, 2> workspaces() const { return {inspect_.get(), annotate_.get()}; }
  Workspace& WorkspaceOf(WorkspaceId id) const;
  Workspace& shown() const { return WorkspaceOf(context_.workspace); }
  /// Of the workspace that shows, and of the window.
  std::vector<ActionGroup> Actions() const;
  void DrawWindow();
  void DrawBarsAndRoom(ImVec2 size);
  void DrawSheetsAndTakeKeys();
  void Remember(const std::string& path);
  void SetUiScale(double scale);
  void SetUpScriptHost();
  void LoadSettings();
  void SaveSettings() const;
  /// The name of the file that was written.
  Result<std::string> SaveScreenshot(const std::string& file, const std::string& of = "");
  void WriteStateFile();
  bool NeedsFrame();
  /// The user has said so and, where something would be lost, has said so again.
  bool Closes();
  /// Says what would be lost with what `workspace` shows; true if there is nothing, or once it was
  /// said and the user does the same again.
  bool MayLose(const Workspace& workspace, const std::string& by_doing);
  void Note(std::string text);

  ApplicationOptions options_;
  std::unique_ptr<PlatformWindow> window_;
  std::unique_ptr<ImGuiBackend> backend_;
  std::unique_ptr<GlTextureStore> textures_;
  WidgetLog widgets_;
  FrameContext context_;
  std::vector<ActionGroup> common_actions_;
  std::optional<UiScript> script_;
  UiScript::Host script_host_;
  Status script_status_;

  PaletteState palette_;
  std::vector<RunningGraph> graphs_;  ///< When the palette was opened.
  bool graphs_read_ = false;
  PathDialog path_dialog_;
  bool quit_ = false;
  std::optional<double> wanted_scale_;
  std::optional<std::string> wanted_path_;
  std::optional<ScreenshotCommand> wanted_screenshot_;
  int screenshot_in_ = 0;  ///< Frames until it is taken: menus and tooltips go first.
  std::string note_, written_state_;
  std::string warned_of_doing_;  ///< As of MayLose, while the note says what it would lose.
  std::chrono::steady_clock::time_point note_until_{};
  int settle_frames_ = 0;  ///< Frames to draw after the last input until ImGui has come to rest.
  std::atomic<bool> published_ = false;
  std::atomic<bool> asked_to_end_ = false;  ///< By a signal, as at the end of a desktop's session.

  // Last: their threads wake the window.
  std::unique_ptr<FolderReader> folders_;
  std::unique_ptr<AnnotateWorkspace> annotate_;
  std::unique_ptr<InspectWorkspace> inspect_;
};

/// Where settings of the window are kept: `$XDG_CONFIG_HOME/plumbline/window.json` or below
/// `~/.config`.
std::filesystem::path DefaultSettingsFile();

}  // namespace plumbline
