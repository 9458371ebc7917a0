// SPDX-License-Identifier: Apache-2.0
// What panels and keys ask the window for.

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include <opencv2/imgcodecs.hpp>

#include "app/window/application.h"
#include "app/window/inspect/bookmarks.h"
#include "engine/runtime/mapping_source.h"

namespace plumbline {
namespace {

constexpr int kSettleFrames = 3;        ///< Until menus and tooltips are gone.
constexpr int kParticleHypothesis = 3;  ///< Where a ProbeView has the particle that was asked for.

}  // namespace

void Application::Send(Command command) {
  const bool to_annotate = std::holds_alternative<AnnotationCommand>(command);
  if (to_annotate ? annotate_->Handle(command) : shown() != nullptr && shown()->Handle(command)) {
    return;
  }
  if (const auto* playback = std::get_if<PlaybackCommand>(&command)) {
    if (const auto* probe = std::get_if<ProbeCommand>(playback)) asked_ = *probe;
    const bool asks = std::holds_alternative<ProbeCommand>(*playback);
    MappingProcess* other = asks ? what_if_->shown_process(context_) : nullptr;
    if (other != nullptr)
      other->Post(*playback);
    else if (process_ != nullptr)
      process_->Post(*playback);
  } else if (const auto* window = std::get_if<WindowCommand>(&command)) {
    Handle(*window);
  }
}

void Application::Handle(const WindowCommand& command) {
  if (what_if_->Handle(command, context_) || views_->Handle(command, context_)) return;
  std::visit(
      [this](const auto& c) {
        using T = std::decay_t<decltype(c)>;
        if constexpr (std::is_same_v<T, SelectObjectCommand>) {
          context_.selection = {c.object, -1, 0};
          auto_select_ = false;
        } else if constexpr (std::is_same_v<T, SelectParticleCommand>) {
          context_.selection.particle = c.particle;
          context_.selection.hypothesis = c.particle >= 0 ? kParticleHypothesis : 0;
          if (c.particle >= 0)
            Send(PlaybackCommand(ProbeCommand{context_.selection.object, c.particle,
                                              asked_.reference, asked_.maps}));
        } else if constexpr (std::is_same_v<T, HoverParticleCommand>) {
          HoverParticle(c.particle);
        } else if constexpr (std::is_same_v<T, FollowCommand>) {
          context_.follow = c.follow;
        } else if constexpr (std::is_same_v<T, FocusSelectionCommand>) {
          if (context_.selection.object.value > 0) scene_->FocusObject(context_.selection.object);
        } else if constexpr (std::is_same_v<T, ResetViewCommand>) {
          context_.follow = context_.look_through = false;
          viewport_ = {};
          scene_->Reset();
        } else if constexpr (std::is_same_v<T, ViewDirectionCommand>) {
          context_.follow = context_.look_through = false;
          scene_->SetDirection(c.azimuth_rad, c.elevation_rad);
        } else if constexpr (std::is_same_v<T, LookThroughCommand>) {
          context_.look_through = c.on;
        } else if constexpr (std::is_same_v<T, SetThemeCommand>) {
          context_.light = c.light;
          wanted_scale_ = context_.ui_scale;
        } else if constexpr (std::is_same_v<T, ShowPaletteCommand>) {
          palette_ = {};
          palette_.open = c.show;
        } else if constexpr (std::is_same_v<T, BookmarkCommand>) {
          std::erase_if(context_.bookmarks, [&](const Bookmark& b) { return b.frame == c.frame; });
          context_.bookmarks.push_back({c.frame, c.note});
          KeepBookmarks();
        } else if constexpr (std::is_same_v<T, RemoveBookmarkCommand>) {
          std::erase_if(context_.bookmarks, [&](const Bookmark& b) { return b.frame == c.frame; });
          KeepBookmarks();
        } else if constexpr (std::is_same_v<T, SelectHypothesisCommand>) {
          context_.selection.hypothesis = c.hypothesis;
        } else if constexpr (std::is_same_v<T, AskFrameCommand>) {
          wanted_ask_frame_ = true;
        } else if constexpr (std::is_same_v<T, ScreenshotCommand>) {
          wanted_screenshot_ = c;
          screenshot_in_ = kSettleFrames;
        } else if constexpr (std::is_same_v<T, ShowHelpCommand>) {
          show_help_ = c.show;
        } else if constexpr (std::is_same_v<T, SetUiScaleCommand>) {
          wanted_scale_ = c.scale;
        } else if constexpr (std::is_same_v<T, OpenCommand>) {
          wanted_path_ = c.path;
        } else if constexpr (std::is_same_v<T, SwitchWorkspaceCommand>) {
          context_.workspace = c.annotate ? WorkspaceId::kAnnotate : WorkspaceId::kInspect;
        } else if constexpr (std::is_same_v<T, PresentCommand>) {
          Present(c.on);
        } else if constexpr (std::is_same_v<T, AskForkCommand>) {
          what_if_->OfferFork(context_);
          fork_sheet_.Open(context_, c.show);
        } else if constexpr (std::is_same_v<T, AskOptionsCommand>) {
          fork_sheet_.OpenOptions(context_, c.show);
        } else if constexpr (std::is_same_v<T, QuitCommand>) {
          quit_ = true;
        }
      },
      command);
}

/// Asks for its outline, one question at a time.
void Application::HoverParticle(int particle) {
  hovered_now_ = particle;
  const ProbeView* known = context_.probe.get();
  const bool answered = known == nullptr || known->hovered == asked_.hovered ||
                        known->object != asked_.object || !known->message.empty();
  const bool shown = known != nullptr && known->hovered == particle &&
                     known->object == context_.selection.object && context_.snapshot != nullptr &&
                     known->frame == context_.snapshot->report.frame;
  if (particle < 0 || shown || !answered || asked_.reference || process_ == nullptr ||
      context_.playback->state == PlaybackState::kPlaying)
    return;
  ProbeCommand ask = asked_;
  ask.object = context_.selection.object;
  ask.particle = context_.selection.particle;
  ask.hovered = particle;
  Send(PlaybackCommand(ask));
}

void Application::KeepBookmarks() {
  std::sort(context_.bookmarks.begin(), context_.bookmarks.end(),
            [](const Bookmark& a, const Bookmark& b) { return a.frame < b.frame; });
  const auto file = BookmarkFile(context_.source, options_.settings);
  Status status = file.empty() ? Status() : WriteBookmarks(file, context_.bookmarks);
  // They belong to the run that the window is mapping, too, if that is kept.
  const std::string& run = context_.playback->recording;
  if (status.ok() && !run.empty() && run != context_.source && !IsTemporaryRun(run))
    status = WriteBookmarks(BookmarkFile(run, {}), context_.bookmarks);
  if (!status.ok()) Note("The bookmarks are not kept: " + status.error().message);
}

Result<std::string> Application::SaveScreenshot(const std::string& file, const std::string& of) {
  std::string name = file;
  for (int i = 1; name.empty(); ++i) {
    const std::string part = of.starts_with("panel.") ? of.substr(6) + "-" : "";
    const std::string candidate = fmt::format("plumbline-{}{:03d}.png", part, i);
    if (!std::filesystem::exists(candidate)) name = candidate;
  }
  std::error_code ignored;
  const auto folder = std::filesystem::path(name).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder, ignored);
  cv::Mat picture = window_->ReadPixels();
  if (!of.empty()) {
    const WidgetLog::Rect* rect = widgets_.Find(of);
    if (rect == nullptr) return Error{ErrorCode::kNotFound, "the window shows no '" + of + "'"};
    const cv::Rect part(cv::Point(cvRound(rect->low.x), cvRound(rect->low.y)),
                        cv::Point(cvRound(rect->high.x), cvRound(rect->high.y)));
    picture = picture(part & cv::Rect({0, 0}, picture.size())).clone();
  }
  if (!cv::imwrite(name, picture)) {
    return Error{ErrorCode::kIo, "cannot write the picture " + name + "; is the folder writable?"};
  }
  return name;
}

}  // namespace plumbline
