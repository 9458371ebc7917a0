// SPDX-License-Identifier: Apache-2.0
#include "ui/common/window_actions.h"

#include <algorithm>
#include <functional>
#include <string>

#include "engine/geometry/angles.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/scene_surface.h"

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

constexpr double kTurn_deg = 15, kSteepest_deg = 89.9;

bool ShowsAnnotate(const FrameContext& context) {
  return context.workspace == WorkspaceId::kAnnotate;
}
bool HasView(const FrameContext& context) {
  return ShowsAnnotate(context) ? context.annotate_scene != nullptr : context.scene != nullptr;
}

std::function<void(const FrameContext&, CommandSink&)> TurnsView(double azimuth_rad,
                                                                 double elevation_rad) {
  return [=](const FrameContext& context, CommandSink& sink) {
    const SceneCamera camera =
        ShowsAnnotate(context) ? context.annotate_scene->camera() : context.scene->camera();
    constexpr double kSteepest = kRadPerDeg * kSteepest_deg;
    sink.Post(ViewDirectionCommand{
        camera.azimuth_rad + azimuth_rad,
        std::clamp(camera.elevation_rad + elevation_rad, -kSteepest, kSteepest)});
  };
}

std::function<void(const FrameContext&, CommandSink&)> ZoomsView(double notches) {
  return [=](const FrameContext& context, CommandSink&) {
    if (ShowsAnnotate(context))
      context.annotate_scene->Zoom(notches);
    else
      context.scene->Zoom(notches);
  };
}

/// A folder; which of them hold batches is not known before.
void AskForBatch(const FrameContext& context) {
  AskPath(context, {.what = PathQuestion::What::kFolder,
                    .title = "Open a batch of runs",
                    .button = "Open",
                    .kinds = {PathKind::kFolder},
                    .answer = [](const std::string& path, CommandSink& sink) {
                      sink.Post(OpenCommand{path});
                    }});
}

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
  const auto turn = [&](int key, const char* text, double azimuth_deg, double elevation_deg) {
    group.actions.push_back({.text = text,
                             .keys = {{key}},
                             .run = TurnsView(kRadPerDeg * azimuth_deg, kRadPerDeg * elevation_deg),
                             .is_offered = HasView,
                             .repeats = true});
  };
  turn(keys::kPad4, "Turn the view to the left", -kTurn_deg, 0);
  turn(keys::kPad6, "Turn the view to the right", kTurn_deg, 0);
  turn(keys::kPad8, "Turn the view up", 0, kTurn_deg);
  turn(keys::kPad2, "Turn the view down", 0, -kTurn_deg);
  turn(keys::kPad9, "Look from the other side", 180, 0);
  group.actions[group.actions.size() - 5].help_keys = "Pad 2 4 6 8 9";
  group.actions[group.actions.size() - 5].help =
      "Turn the view by 15\u00b0, or to the other side (number pad; + and \u2212 zoom)";
  const auto zoom = [&](int key, const char* text, double notches) {
    group.actions.push_back({.text = text,
                             .keys = {{key}},
                             .run = ZoomsView(notches),
                             .is_offered = HasView,
                             .repeats = true});
  };
  zoom(keys::kPadPlus, "Zoom the view in", 1);
  zoom(keys::kPadMinus, "Zoom the view out", -1);
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
           {.text = "Open a batch of runs",
            .run = [](const FrameContext& context, CommandSink&) { AskForBatch(context); }},
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
