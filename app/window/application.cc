// SPDX-License-Identifier: Apache-2.0
#include "app/window/application.h"

#include <algorithm>
#include <cfloat>
#include <cstdlib>
#include <thread>
#include <utility>

#include "app/platform/interrupts.h"
#include "engine/base/log.h"
#include "engine/base/timer.h"
#include "ui/common/frame_bars.h"
#include "ui/common/welcome.h"
#include "ui/common/window_actions.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr int kSettleFrames = 3;
constexpr double kNoteSeconds = 5;
constexpr std::size_t kMaxRecent = 8;

std::string HomeFolder() {
  const char* home = std::getenv("HOME");
  return home == nullptr || *home != '/' ? "/" : home;
}

std::string WorkingFolder() {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::current_path(error);
  return error ? HomeFolder() : folder.string();
}

}  // namespace

Result<std::unique_ptr<Application>> Application::Create(ApplicationOptions options) {
  std::optional<UiScript> script;
  if (!options.script.empty()) {
    auto loaded = UiScript::Load(options.script);
    if (!loaded.ok()) return loaded.error();
    script = std::move(loaded).value();
  }
  auto window = PlatformWindow::Open("Plumbline", options.width, options.height);
  if (!window.ok()) return window.error();
  std::unique_ptr<Application> application(
      new Application(std::move(options), std::move(window).value()));
  application->script_ = std::move(script);
  return application;
}

Application::Application(ApplicationOptions options, std::unique_ptr<PlatformWindow> window)
    : options_(std::move(options)),
      window_(std::move(window)),
      backend_(std::make_unique<ImGuiBackend>(*window_)),
      textures_(std::make_unique<GlTextureStore>()),
      common_actions_{ViewActions(), WindowActions()},
      path_dialog_(HomeFolder(), WorkingFolder()) {
  context_.renderer = window_->renderer();
  context_.textures = textures_.get();
  context_.widgets = &widgets_;
  context_.path_dialog = &path_dialog_;
  context_.light = options_.light;
  const auto wake = [this] {
    published_ = true;
    PlatformWindow::Wake();
  };
  folders_ = std::make_unique<FolderReader>(wake);
  const bool software_gl = window_->software_gl();
  options_.inspect.settings = options_.settings;
  annotate_ = std::make_unique<AnnotateWorkspace>(options_.annotation, software_gl, wake);
  inspect_ =
      std::make_unique<InspectWorkspace>(options_.inspect, software_gl, context_, *this, wake);
  wanted_scale_ = window_->content_scale();
  LoadSettings();
  if (options_.ui_scale) wanted_scale_ = options_.ui_scale;
  SetUpScriptHost();
  if (!options_.path.empty()) Open(options_.path, options_.start_frame);
  if (!options_.compare.empty()) inspect_->Compare(options_.compare, context_);
  if (options_.play) Post(PlayCommand{});
}

Application::~Application() {
  SaveSettings();
  inspect_.reset();
  annotate_.reset();
  folders_.reset();
  textures_.reset();
  backend_.reset();
}

void Application::SetUpScriptHost() {
  script_host_.screenshot = [this](const std::string& file, const std::string& of) -> Status {
    const auto saved = SaveScreenshot(file, of);
    return saved.ok() ? Status() : Status(saved.error());
  };
  script_host_.state = [this] {
    nlohmann::json state = State();
    state["window_ms"] = context_.window_ms;
    state["scene_ms"] = context_.scene_ms;
    return state;
  };
  script_host_.resize = [this](int width, int height) { window_->Resize(width, height); };
  script_host_.drop = [this](std::vector<std::string> files) { window_->Drop(std::move(files)); };
  script_host_.open = [this](const std::string& path) { Open(path, std::nullopt); };
}

Workspace& Application::WorkspaceOf(WorkspaceId id) const {
  for (Workspace* workspace : workspaces()) {
    if (workspace->tab().id == id) return *workspace;
  }
  return *inspect_;
}

void Application::Open(const std::string& path, std::optional<int> frame) {
  if (NamesGraph(path)) {  // not remembered: it ends
    context_.workspace = WorkspaceId::kInspect;
    if (MayLose(*inspect_, "open " + path)) inspect_->Open(path, frame, context_);
    return;
  }
  if (std::filesystem::exists(std::filesystem::path(path) / "models.json") &&
      !std::filesystem::exists(std::filesystem::path(path) / "camera.json"))
    return OpenModels(path);
  if (std::filesystem::path(path).extension() == ".onnx") {
    context_.workspace = WorkspaceId::kInspect;
    return inspect_->LookAtNetwork(path);
  }
  if (IsBatch(path)) {
    context_.workspace = WorkspaceId::kInspect;
    Remember(path);
    return inspect_->LookAtBatch(path);
  }
  Workspace& workspace = annotate_->Takes(path) ? static_cast<Workspace&>(*annotate_) : *inspect_;
  context_.workspace = workspace.tab().id;
  if (!MayLose(workspace, "open " + path)) return;
  Remember(path);
  workspace.Open(path, frame, context_);
}

void Application::OpenModels(const std::string& folder) {
  if (!MayLose(shown(), "open " + folder)) return;
  for (Workspace* workspace : workspaces()) workspace->UseModels(folder);
  const std::string open = shown().source();
  if (open.empty()) return Note("These models are taken with what is opened next: " + folder);
  const bool at_frame = context_.workspace == WorkspaceId::kInspect;
  Open(open, at_frame ? std::optional(context_.playback->frame) : std::nullopt);
  Note("Opened again with the models of " + folder);
}

void Application::Remember(const std::string& path) {
  const std::string absolute =
      path == kDemoPath ? path : std::filesystem::absolute(path).lexically_normal().string();
  std::erase(context_.recent, absolute);
  context_.recent.insert(context_.recent.begin(), absolute);
  if (context_.recent.size() > kMaxRecent) context_.recent.resize(kMaxRecent);
}

void Application::Note(std::string text) {
  note_ = std::move(text);
  note_until_ = std::chrono::steady_clock::now() +
                std::chrono::milliseconds(static_cast<int>(1000 * kNoteSeconds));
}

void Application::SetUiScale(double scale) {
  context_.ui_scale = std::clamp(scale, 0.6, 4.0);
  context_.fonts = ApplyTheme(context_.ui_scale, context_.light);
  backend_->ReloadFonts();
}

bool Application::NeedsFrame() {
  const bool note_ended = !note_.empty() && std::chrono::steady_clock::now() > note_until_;
  if (note_ended) note_.clear();
  if (window_->TakeActivity() || window_->HasInput() || published_.exchange(false) || note_ended ||
      shown().Moves(context_))
    settle_frames_ = kSettleFrames;
  if (script_ || wanted_screenshot_) return true;
  return settle_frames_-- > 0;
}

bool Application::Closes() {
  if (asked_to_end_.exchange(false)) quit_ = true;
  if (!quit_ && !window_->ShouldClose()) return false;
  for (const Workspace* workspace : workspaces()) {
    if (MayLose(*workspace, "close")) continue;
    quit_ = false;
    window_->StayOpen();
    return false;
  }
  return true;
}

bool Application::MayLose(const Workspace& workspace, const std::string& by_doing) {
  const std::string lost = workspace.WouldBeLost(context_);
  const bool warned = note_ == lost && warned_of_doing_ == by_doing;
  if (lost.empty() || warned) return true;
  Note(lost);
  warned_of_doing_ = by_doing;
  return false;
}

Status Application::Run() {
  const Interrupts interrupts([this] {
    asked_to_end_ = true;
    PlatformWindow::Wake();
  });
  while (!Closes()) {
    const Pace pace = shown().pace(context_);
    window_->TakeEvents(script_ ? 0 : settle_frames_ > 0 ? pace.shortest_s : pace.longest_s);
    for (const std::string& file : window_->TakeDroppedFiles()) wanted_path_ = file;
    if (wanted_path_) Open(*std::exchange(wanted_path_, std::nullopt), std::nullopt);
    if (!NeedsFrame()) continue;
    const Stopwatch watch;
    DrawFrame();
    if (const double rest_ms = options_.least_frame_ms - watch.Milliseconds(); rest_ms > 0)
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(rest_ms));
    if (!options_.state_file.empty()) WriteStateFile();
    if (script_ && (!script_status_.ok() || script_->done())) break;
  }
  return script_status_;
}

void Application::DrawFrame(cv::Mat* picture) {
  const Stopwatch watch;
  for (Workspace* workspace : workspaces()) workspace->ReadSlots(context_);
  if (wanted_scale_) SetUiScale(*std::exchange(wanted_scale_, std::nullopt));
  backend_->TakeInput();
  if (script_ && script_status_.ok())
    script_status_ = script_->SetInput(widgets_, ImGui::GetIO(), script_host_);
  if (options_.ignore_pointer || wanted_screenshot_) ImGui::GetIO().MousePos = {-FLT_MAX, -FLT_MAX};
  ImGui::NewFrame();
  widgets_.Clear();
  DrawWindow();
  ImGui::Render();
  backend_->Draw();
  context_.window_ms = watch.Milliseconds();
  context_.scene_ms = context_.scene->last_render_ms();
  if (picture != nullptr) *picture = window_->ReadPixels();
  if (wanted_screenshot_ && screenshot_in_-- == 0) {
    const auto saved = SaveScreenshot(wanted_screenshot_->file, wanted_screenshot_->of);
    Note(saved.ok() ? "Saved the picture as " + *saved : saved.error().message);
    wanted_screenshot_.reset();
  }
  if (script_ && script_status_.ok()) script_status_ = script_->AfterDraw(script_host_);
  window_->Swap();
}

void Application::DrawWindow() {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize(size);
  ImGui::Begin("Plumbline", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus |
                   ImGuiWindowFlags_NoScrollWithMouse);
  const bool alone = shown().FillsWindow();
  if (alone)
    shown().Draw(context_, {{0, 0}, size}, *this);
  else
    DrawBarsAndRoom(size);
  ImGui::End();
  if (!alone) DrawSheetsAndTakeKeys();
}

void Application::DrawBarsAndRoom(ImVec2 size) {
  const WindowLayout layout = ComputeWindowLayout(size, context_.ui_scale);
  std::vector<WorkspaceTab> tabs;
  for (const Workspace* workspace : workspaces()) tabs.push_back(workspace->tab());
  Workspace& workspace = shown();
  DrawTopBar(
      context_, layout.top_bar, tabs,
      [&](const LayoutRect& middle) { workspace.DrawBar(context_, middle, *this); }, *this);
  if (workspace.IsOpen(context_))
    workspace.Draw(context_, layout.room, *this);
  else
    DrawWelcome(context_, layout.room, *this);
  DrawStatusBar(context_, layout.status_bar, workspace.status_line(context_), note_);
}

std::vector<ActionGroup> Application::Actions() const {
  std::vector<ActionGroup> actions = shown().actions();
  actions.insert(actions.end(), common_actions_.begin(), common_actions_.end());
  return actions;
}

void Application::DrawSheetsAndTakeKeys() {
  Workspace& workspace = shown();
  // A key that closes a sheet does nothing else.
  const bool help = context_.help_shown, palette = palette_.open;
  if (help) DrawHelpSheet(context_, Actions(), *this);
  const bool sheet = workspace.DrawSheets(context_, *this);
  if (palette && !graphs_read_) graphs_ = GraphsOfThisMachine();
  graphs_read_ = palette;
  if (palette) {
    const std::vector<ActionGroup> actions = Actions();
    std::vector<PaletteEntry> entries = EntriesOf(actions, context_);
    workspace.AddPaletteEntries(context_, entries);
    AddRecentEntries(context_, entries);
    for (const RunningGraph& running : graphs_)
      entries.push_back(EntryFor("Look on at the graph that writes " +
                                     running.run.filename().string() + " (" + running.graph.name +
                                     ")",
                                 OpenCommand{running.graph.name}));
    DrawPalette(
        context_, palette_, std::move(entries),
        [&](const std::string& query) { return workspace.AnswerPalette(context_, query); }, *this);
  }
  if (const auto folder = path_dialog_.TakeWanted()) folders_->Read(*folder);
  path_dialog_.Take(folders_->View());
  const bool path = path_dialog_.Draw(context_, *this);
  if (palette || sheet || path) return;
  RunKeys(workspace.actions(), context_, *this);
  RunKeys(common_actions_, context_, *this);
  if (!help) workspace.WatchKeys(context_, *this);
  if (help && ImGui::IsKeyPressed(keys::kEscape, false)) context_.help_shown = false;
}

}  // namespace plumbline
