// SPDX-License-Identifier: Apache-2.0
// What panels and keys ask for, and who does it.

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "app/window/application.h"
#include "engine/base/overloaded.h"

namespace plumbline {
namespace {

constexpr int kFramesUntilTaken = 3;  ///< Until menus and tooltips are gone.

}  // namespace

void Application::Send(Command command) {
  std::visit(Overloaded{[&](const PlaybackCommand& c) { inspect_->Handle(c, context_); },
                        [&](const InspectCommand& c) { inspect_->Handle(c, context_); },
                        [&](const ViewCommand& c) { shown().Handle(c, context_); },
                        [&](const AnnotationCommand& c) { annotate_->Handle(c); },
                        [&](const WindowCommand& c) { Handle(c); }},
             command);
}

void Application::Handle(const WindowCommand& command) {
  std::visit(Overloaded{[&](const SetThemeCommand& c) {
                          context_.light = c.light;
                          wanted_scale_ = context_.ui_scale;
                        },
                        [&](const ShowPaletteCommand& c) {
                          palette_ = {};
                          palette_.open = c.show;
                          palette_.within = c.within;
                        },
                        [&](const ScreenshotCommand& c) {
                          wanted_screenshot_ = c;
                          screenshot_in_ = kFramesUntilTaken;
                        },
                        [&](const NoteCommand& c) { Note(c.text); },
                        [&](const FullScreenCommand& c) { window_->SetFullScreen(c.on); },
                        [&](const ShowHelpCommand& c) { context_.help_shown = c.show; },
                        [&](const SetUiScaleCommand& c) { wanted_scale_ = c.scale; },
                        [&](const OpenCommand& c) { wanted_path_ = c.path; },
                        [&](const SwitchWorkspaceCommand& c) { context_.workspace = c.workspace; },
                        [&](const QuitCommand&) { quit_ = true; }},
             command);
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
