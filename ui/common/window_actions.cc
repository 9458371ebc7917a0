// SPDX-License-Identifier: Apache-2.0
#include "ui/common/window_actions.h"

#include <string>

#include "engine/geometry/angles.h"
#include "ui/framework/path_dialog.h"

namespace plumbline {
namespace {

/// A direction from which the 3-D view is looked at.
struct AxisView {
  char key;
  const char* name;
  double azimuth_deg, elevation_deg;
  KeyStroke pad;  ///< Of the number pad, as Blender has them.
};
constexpr AxisView kAxisViews[] = {{'1', "the front (-y)", -90, 0, {keys::kPad1}},
                                   {'2', "the back (+y)", 90, 0, {keys::kPad1, false, true}},
                                   {'3', "the left (-x)", 180, 0, {keys::kPad3, false, true}},
                                   {'4', "the right (+x)", 0, 0, {keys::kPad3}},
                                   {'5', "above", -90, 89.9, {keys::kPad7}},
                                   {'6', "an angle", -55, 35, {keys::kPad0}}};

}  // namespace

void AskWhatToOpen(const FrameContext& context) {
  AskPath(context, {.title = "Open",
                    .button = "Open",
                    .kinds = {PathKind::kSequence, PathKind::kRun, PathKind::kScan,
                              PathKind::kProject, PathKind::kModels},
                    .offers_recent = true,
                    .answer = [](const std::string& path, CommandSink& sink) {
                      sink.Post(OpenCommand{path});
                    }});
}

ActionGroup ViewActions() {
  ActionGroup group{"View", {}};
  group.actions = {{.text = "Frame the selected object in 3-D",
                    .keys = {{keys::kF}, {keys::kPadPoint}},
                    .run = Posts(FocusSelectionCommand{}),
                    .help_keys = "F",
                    .help = "Frame the selected object in 3-D"},
                   {.text = "Reset the views",
                    .keys = {{keys::kR}},
                    .run = Posts(ResetViewCommand{}),
                    .help_keys = "R",
                    .help = "Reset the views"}};
  for (const AxisView& view : kAxisViews) {
    const bool first = view.key == kAxisViews[0].key;
    group.actions.push_back(
        {.text = std::string("View from ") + view.name,
         .keys = {{view.key}, view.pad},
         .run = Posts(
             ViewDirectionCommand{kRadPerDeg * view.azimuth_deg, kRadPerDeg * view.elevation_deg}),
         .help_keys = first ? "1 .. 6" : "",
         .help = first ? "View from front, back, left, right, above or obliquely (number pad: 1, "
                         "3, 7, with Ctrl the other side)"
                       : ""});
  }
  return group;
}

ActionGroup WindowActions() {
  const auto scale = [](double factor) {
    return [factor](const FrameContext& context, CommandSink& sink) {
      sink.Post(SetUiScaleCommand{context.ui_scale * factor});
    };
  };
  return {"Window",
          {{.text = "Open a sequence, a run, a scan or a project",
            .keys = {{keys::kO, false, true}},
            .run = [](const FrameContext& context, CommandSink&) { AskWhatToOpen(context); },
            .help_keys = "Ctrl + O",
            .help = "Open a sequence, a run, a scan, a project or models"},
           {.text = "Open a folder of scans, as a queue",
            .run =
                [](const FrameContext& context, CommandSink&) {
                  AskPath(context, {.what = PathQuestion::What::kFolder,
                                    .title = "Open a folder of scans",
                                    .button = "Open",
                                    .answer = [](const std::string& path, CommandSink& sink) {
                                      sink.Post(OpenCommand{path});
                                    }});
                }},
           {.text = "Take models from a folder",
            .run =
                [](const FrameContext& context, CommandSink&) {
                  AskPath(context, {.title = "Take models from a folder",
                                    .button = "Take",
                                    .kinds = {PathKind::kModels},
                                    .answer = [](const std::string& path, CommandSink& sink) {
                                      sink.Post(OpenCommand{path});
                                    }});
                }},
           {.text = "Light theme",
            .keys = {{keys::kL, false, true}},
            .run = [](const FrameContext& context,
                      CommandSink& sink) { sink.Post(SetThemeCommand{!context.light}); },
            .help_keys = "Ctrl + L",
            .help = "Light or dark theme",
            .text_when_on = "Dark theme",
            .is_on = [](const FrameContext& context) { return context.light; }},
           {.text = "Larger text",
            .keys = {{keys::kEqual, false, true}},
            .run = scale(1.1),
            .help_keys = "Ctrl + \u2212  =",
            .help = "Smaller or larger text"},
           {.text = "Smaller text", .keys = {{keys::kMinus, false, true}}, .run = scale(1 / 1.1)},
           {.keys = {{keys::kP, false, true}, {keys::kK, false, true}},
            .run = Posts(ShowPaletteCommand{true}),
            .help_keys = "Ctrl + P",
            .help = "Find anything: actions, objects, frames, files"},
           {.text = "Save a picture of the window",
            .keys = {{keys::kF12}},
            .run = Posts(ScreenshotCommand{}),
            .help_keys = "F12",
            .help = "Save a picture of the window (Shift: under a name of your own)"},
           {.text = "Save a picture of the window as",
            .keys = {{keys::kF12, true}},
            .run =
                [](const FrameContext& context, CommandSink&) {
                  AskPath(context, {.what = PathQuestion::What::kSave,
                                    .title = "Save a picture of the window",
                                    .button = "Save",
                                    .at = "plumbline.png",
                                    .ending = ".png",
                                    .answer = [](const std::string& path, CommandSink& sink) {
                                      sink.Post(ScreenshotCommand{path, ""});
                                    }});
                }},
           {.text = "Keys and mouse",
            .keys = {{keys::kF1}, {keys::kSlash, true}},
            .run = [](const FrameContext& context,
                      CommandSink& sink) { sink.Post(ShowHelpCommand{!context.help_shown}); },
            .help_keys = "F1  ?",
            .help = "This sheet"},
           {.text = "Quit",
            .keys = {{keys::kQ, false, true}},
            .run = Posts(QuitCommand{}),
            .help_keys = "Ctrl + Q",
            .help = "Quit"}}};
}

}  // namespace plumbline
