// SPDX-License-Identifier: Apache-2.0
#include "app/window/application.h"

#include <algorithm>
#include <cfloat>
#include <utility>

#include "app/window/inspect/bookmarks.h"
#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/base/timer.h"
#include "engine/snapshot/annotation_snapshot.h"
#include "ui/common/frame_bars.h"
#include "ui/common/welcome.h"
#include "ui/framework/shortcuts.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/panels.h"
#include "ui/scene/map_scene.h"

namespace plumbline {
namespace {

constexpr int kSettleFrames = 3;
constexpr double kNoteSeconds = 5;
constexpr std::size_t kMaxRecent = 8;
constexpr double kIdleWakeSeconds = 1.0, kBlinkWakeSeconds = 0.05, kPresentWaitSeconds = 0.01;

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
    : options_(std::move(options)), window_(std::move(window)) {
  backend_ = std::make_unique<ImGuiBackend>(*window_);
  textures_ = std::make_unique<GlTextureStore>();
  scene_ = CreateMapScene(window_->software_gl());
  image_ = MakeImagePanel();
  edges_ = MakeEdgesPanel();
  depth_ = MakeDepthPanel();
  masks_ = MakeMasksPanel();
  particles_ = MakeParticlesPanel();
  map_ = MakeScenePanel();
  objects_ = MakeObjectsPanel();
  relations_ = MakeRelationsPanel();
  details_ = MakeDetailsPanel();
  timings_ = MakeTimingsPanel();
  timeline_ = MakeTimelinePanel();
  why_ = MakeWhyPanel();
  particle_table_ = MakeParticleTablePanel();
  posterior_ = MakePosteriorPanel();
  flow_ = MakeFlowPanel();
  what_if_panel_ = MakeWhatIfPanel();
  other_image_ = MakeOtherImagePanel();
  for (const auto* panel :
       {&image_, &edges_, &depth_, &masks_, &particles_, &map_, &objects_, &relations_, &details_,
        &timings_, &timeline_, &why_, &particle_table_, &posterior_, &flow_, &what_if_panel_}) {
    panels_.push_back(panel->get());
  }
  views_ = std::make_unique<ImageViews>(
      ImageViews::Panels{image_.get(), edges_.get(), depth_.get(), masks_.get(), particles_.get()});
  context_.playback = std::make_shared<const PlaybackView>();
  annotate_ =
      std::make_unique<AnnotateWorkspace>(options_.annotation, window_->software_gl(), [this] {
        published_ = true;
        PlatformWindow::Wake();
      });
  what_if_ = std::make_unique<WhatIf>(
      [this](const std::string& path) { return options_.opener(path, models_); }, options_.inputs,
      options_.program_version,
      [this] {
        published_ = true;
        PlatformWindow::Wake();
      });
  context_.renderer = window_->renderer();
  context_.textures = textures_.get();
  context_.widgets = &widgets_;
  context_.viewport = &viewport_;
  context_.scene = scene_.get();
  wanted_scale_ = window_->content_scale();
  context_.light = options_.light;
  LoadSettings();
  if (options_.ui_scale) wanted_scale_ = options_.ui_scale;
  for (Panel* panel : panels_) {
    if (options_.layout != nullptr && options_.layout->states.contains(panel->Id()))
      panel->LoadState(options_.layout->states.at(panel->Id()));
  }
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
  if (!options_.path.empty()) Open(options_.path, options_.start_frame);
  if (!options_.compare.empty()) what_if_->Compare(options_.compare, context_);
  if (options_.play && process_ != nullptr) process_->Post(PlayCommand{});
}

Application::~Application() {
  process_.reset();
  what_if_.reset();
  SaveSettings();
  annotate_.reset();
  scene_.reset();
  textures_.reset();
  backend_.reset();
}

void Application::Open(const std::string& path, std::optional<int> frame) {
  if (std::filesystem::exists(std::filesystem::path(path) / "models.json") &&
      !std::filesystem::exists(std::filesystem::path(path) / "camera.json"))
    return OpenModels(path);
  if (annotate_->Takes(path)) {
    context_.workspace = WorkspaceId::kAnnotate;
    Remember(path);
    return annotate_->Open(path, context_);
  }
  context_.workspace = WorkspaceId::kInspect;
  process_.reset();
  context_.sequence = nullptr;
  context_.snapshot = nullptr;
  context_.selection = {options_.select, -1, 0};
  auto_select_ = options_.select.value <= 0;
  context_.bare = options_.layout != nullptr && !options_.layout->panels.empty();
  context_.look_through =
      options_.layout != nullptr && std::string_view(options_.layout->name) == "through";
  context_.source = path;
  ++context_.source_version;
  context_.bookmarks = ReadBookmarks(BookmarkFile(path, options_.settings));
  what_if_->Opened(context_);
  Remember(path);
  process_ = std::make_unique<MappingProcess>(options_.opener(path, models_), frame, [this] {
    published_ = true;
    PlatformWindow::Wake();
  });
  context_.playback = process_->Playback();
}

void Application::OpenModels(const std::string& folder) {
  models_ = folder;
  what_if_->UseModels(folder);
  annotate_->UseModels(folder);
  const std::string open = shown() == nullptr               ? context_.source
                           : context_.annotation != nullptr ? annotate_->source()
                                                            : "";
  if (open.empty()) return Note("These models are taken with what is opened next: " + folder);
  Open(open, shown() == nullptr ? std::optional(context_.playback->frame) : std::nullopt);
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

void Application::ReadSlots() {
  annotate_->ReadSlots(context_);
  if (process_ == nullptr) return;
  context_.playback = process_->Playback();
  context_.sequence = process_->Sequence();
  context_.probe = process_->Probe();
  auto snapshot = context_.first_snapshot = process_->Snapshot();
  what_if_->ReadSlots(context_, snapshot);
  if (snapshot != context_.snapshot) {
    context_.snapshot = std::move(snapshot);
    ++context_.snapshot_version;
    if (context_.selection.particle >= 0) context_.selection.particle = -1;
  }
  if (auto_select_ && context_.snapshot != nullptr) SelectByItself();
}

/// Keeps what is selected for as long as it shows; then the object that shows largest.
void Application::SelectByItself() {
  const ObjectReport* selected = context_.SelectedObject();
  if (selected != nullptr && selected->weighed) return;
  float largest = 0;
  for (const ObjectReport& object : context_.snapshot->report.objects) {
    if (!object.weighed || object.visible_box.empty()) continue;
    const float area = object.visible_box.width() * object.visible_box.height() *
                       (object.state == ObjectState::kConfirmed ? 4.0f : 1.0f);
    if (area <= largest) continue;
    largest = area;
    context_.selection.object = object.id;
  }
}

bool Application::NeedsFrame() {
  const bool note_ended = !note_.empty() && std::chrono::steady_clock::now() > note_until_;
  if (note_ended) note_.clear();
  if (window_->TakeActivity() || window_->HasKeys() || published_.exchange(false) || note_ended)
    settle_frames_ = kSettleFrames;
  if (script_ || presenter_.active() || wanted_screenshot_) return true;
  if (what_if_->TakeBlink(context_)) settle_frames_ = kSettleFrames;
  return settle_frames_-- > 0;
}

Status Application::Run() {
  while (!quit_ && !window_->ShouldClose()) {
    const double shortest = presenter_.active() && !script_ ? kPresentWaitSeconds : 0.0;
    const double longest =
        context_.run_shown == RunShown::kBlink ? kBlinkWakeSeconds : kIdleWakeSeconds;
    window_->TakeEvents(script_ || settle_frames_ > 0 ? shortest : longest);
    for (const std::string& file : window_->TakeDroppedFiles()) wanted_path_ = file;
    if (wanted_path_) Open(*std::exchange(wanted_path_, std::nullopt), std::nullopt);
    if (!NeedsFrame()) continue;
    DrawFrame();
    if (!options_.state_file.empty()) WriteStateFile();
    if (script_ && (!script_status_.ok() || script_->done())) break;
  }
  return script_status_;
}

void Application::DrawFrame(cv::Mat* picture) {
  const Stopwatch watch;
  ReadSlots();
  if (wanted_scale_) SetUiScale(*std::exchange(wanted_scale_, std::nullopt));
  backend_->TakeInput();
  if (script_ && script_status_.ok())
    script_status_ = script_->SetInput(widgets_, ImGui::GetIO(), script_host_);
  if (options_.ignore_pointer || wanted_screenshot_) ImGui::GetIO().MousePos = {-FLT_MAX, -FLT_MAX};
  ImGui::NewFrame();
  widgets_.Clear();
  context_.selection.hovered = std::exchange(hovered_now_, -1);
  context_.ask_frame = std::exchange(wanted_ask_frame_, false);
  DrawWindow();
  ImGui::Render();
  backend_->Draw();
  context_.window_ms = watch.Milliseconds();
  context_.scene_ms = scene_->last_render_ms();
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
  if (options_.layout != nullptr && !options_.layout->panels.empty()) {
    DrawFigure(size);
    ImGui::End();
    return;
  }
  if (options_.present && context_.snapshot != nullptr) {
    Present(std::exchange(options_.present, false));
    quit_after_presenting_ = presenter_.active();
  }
  if (presenter_.active()) {
    DrawPresentation(size);
    ImGui::End();
    return;
  }
  const InspectLayout layout = ComputeInspectLayout(size, context_.ui_scale, ratios_);
  DrawTopBar(context_, layout.top_bar, *this);
  const LayoutRect room{{0, layout.top_bar.high.y}, {size.x, layout.status_bar.low.y}};
  if (shown() == nullptr) {
    DrawInspect(layout);
  } else if (context_.annotation != nullptr && !context_.annotation->project_file.empty()) {
    shown()->Draw(context_, room, *this);
  } else {
    DrawWelcome(context_, room, *this);
  }
  DrawStatusBar(context_, layout.status_bar, note_);
  ImGui::End();
  if (show_help_) DrawHelpSheet(context_, *this);
  fork_sheet_.Draw(context_, *this);
  DrawPalette(context_, palette_, *this);
  if (palette_.open || fork_sheet_.is_open()) return;
  PostShortcuts(context_, show_help_, *this);
  if (shown() != nullptr && !show_help_) shown()->PostShortcuts(context_, *this);
}

void Application::Present(bool on) {
  if (on && (context_.sequence == nullptr || shown() != nullptr)) return;
  window_->SetFullScreen(on);
  if (on)
    presenter_.Start(context_, panels_, *this);
  else
    presenter_.Stop(context_, panels_, *this);
}

void Application::DrawPresentation(ImVec2 size) {
  if (!presenter_.Draw(context_, size, panels_, *this)) return;
  Present(false);
  quit_ = quit_after_presenting_;
}

void Application::DrawInspect(const InspectLayout& layout) {
  if (context_.sequence != nullptr) return DrawPanels(layout);
  DrawWelcome(context_, {layout.image.low, {layout.scene.high.x, layout.timeline.high.y}}, *this);
}

void Application::DrawFigure(ImVec2 size) {
  const float gap = context_.Scaled(4);
  for (const PlacedPanel& placed : options_.layout->panels) {
    const LayoutRect rect{{placed.x0 * size.x + 0.5f * gap, placed.y0 * size.y + 0.5f * gap},
                          {placed.x1 * size.x - 0.5f * gap, placed.y1 * size.y - 0.5f * gap}};
    for (Panel* panel : panels_) {
      if (std::string_view(panel->Id()) == placed.panel) DrawPanel(context_, rect, *panel, *this);
    }
  }
}

void Application::DrawPanels(const InspectLayout& layout) {
  const bool beside = context_.run_shown == RunShown::kBeside && context_.other != nullptr;
  if (beside) other_image_->LoadState(image_->SaveState());
  views_->Draw(context_, layout, beside ? other_image_.get() : nullptr, *this);
  DrawPanel(context_, layout.scene, *map_, *this);
  Panel* const about_map[] = {objects_.get(), relations_.get(), what_if_panel_.get()};
  DrawTabbedPanels(context_, layout.objects, about_map, objects_tab_, *this);
  Panel* const about_object[] = {details_.get(), why_.get(), posterior_.get(),
                                 particle_table_.get()};
  LayoutRect details = layout.details;
  const bool wide = details_tab_ > 0;
  if (wide) details.high = layout.timings.high;  // it needs the room
  DrawTabbedPanels(context_, details, about_object, details_tab_, *this);
  if (!wide) DrawPanel(context_, layout.timings, *timings_, *this);
  DrawPanel(context_, layout.timeline, *timeline_, *this);
  DragSplitters(context_, layout, ratios_);
}

}  // namespace plumbline
