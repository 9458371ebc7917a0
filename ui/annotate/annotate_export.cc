// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>

#include "engine/snapshot/export_formats.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kSheetWidth = 470, kSheetHeight = 344, kAskingHeight = 546;
constexpr double kExportLabelWidth = 84;

void Label(const FrameContext& context, const char* text) {
  ImGui::AlignTextToFramePadding();
  DimText("%s", text);
  ImGui::SameLine(context.Scaled(kExportLabelWidth));
}

/// Beside the project.
std::string UsualPath(const AnnotationSnapshot& snapshot, const ExportFormat& format) {
  const std::size_t slash = snapshot.project_file.rfind('/');
  return (slash == std::string::npos ? "" : snapshot.project_file.substr(0, slash + 1)) +
         format.file;
}

void DrawFrames(const FrameContext& context, const ExportFormat& format) {
  AnnotateView& view = *context.annotate;
  const AnnotationSnapshot& snapshot = *context.annotation;
  struct Choice {
    const char *frame, *label, *help;
    bool offered;
  };
  const Choice choices[] = {
      {"scan", "the scan's own", "Coordinates as in the file of the scan, whatever up is there.",
       true},
      {"level", "level", "z up against gravity, the floor at 0: as the window shows it.",
       format.level},
      {"world", "the sequence's", "The world in which the sequence's camera poses are.",
       format.world && snapshot.has_sequence}};
  if (!format.level) {
    Label(context, "Frame");
    ImGui::TextUnformatted(format.needs_sequence ? "each camera's" : "level, y up");
    return;
  }
  const bool known = std::any_of(std::begin(choices), std::end(choices), [&](const Choice& c) {
    return c.offered && view.export_frame == c.frame;
  });
  if (!known) view.export_frame = "scan";
  Label(context, "Frame");
  for (const Choice& choice : choices) {
    if (!choice.offered) continue;
    bool on = view.export_frame == choice.frame;
    if (Toggle(context, std::string("export.frame.") + choice.frame, choice.label, on,
               choice.help)) {
      view.export_frame = choice.frame;
    }
    ImGui::SameLine(0, context.Scaled(3));
  }
  ImGui::NewLine();
}

/// Where it is written. The sheet, which gives way to the dialog, comes back afterwards.
PathQuestion ExportQuestion(const FrameContext& context, const ExportFormat& format) {
  AnnotateView& view = *context.annotate;
  return {.what = PathQuestion::What::kSave,
          .title = std::string("Export as ") + format.title,
          .button = "Take it",
          .at = view.export_out,
          .ending = std::filesystem::path(format.file).extension().string(),
          .may_replace = true,
          .answer =
              [&view](const std::string& path, CommandSink&) {
                view.export_out = path;
                view.open_export = true;
              },
          .gave_up = [&view] { view.open_export = true; }};
}

/// What would be replaced, and whether it may be.
void DrawQuestion(const FrameContext& context, const ExportView& exported, CommandSink& sink) {
  WrappedText(colors::kWarning, exported.out + " is there already, and differs:");
  for (const std::string& difference : exported.differences) WrappedText(colors::kText, difference);
  ImGui::Dummy({0, context.Scaled(2)});
  if (Button(context, "export.replace", "Replace it",
             "What is there is kept beside it, as .bak.")) {
    sink.Post(AnswerExportCommand{true});
  }
  ImGui::SameLine(0, context.Scaled(6));
  if (Button(context, "export.leave", "Leave it", "Nothing is written.")) {
    sink.Post(AnswerExportCommand{false});
  }
}

/// What is open, and whether it is written all the same.
void DrawOpenFindings(const FrameContext& context, const ExportView& exported,
                      const ExportCommand& command, CommandSink& sink) {
  constexpr std::size_t kListed = 6;
  const std::size_t count = exported.open_findings.size();
  WrappedText(colors::kWarning, count == 1 ? "Nothing was written yet. A finding is open:"
                                           : "Nothing was written yet. " + std::to_string(count) +
                                                 " findings are open:");
  for (std::size_t i = 0; i < std::min(count, kListed); ++i) {
    WrappedText(colors::kText, exported.open_findings[i]);
  }
  if (count > kListed) DimText("and %zu more", count - kListed);
  ImGui::Dummy({0, context.Scaled(2)});
  if (Button(context, "export.look", "Look at them", "Shows the list, to walk through.")) {
    context.annotate->check = true;
    ImGui::CloseCurrentPopup();
  }
  ImGui::SameLine(0, context.Scaled(6));
  if (Button(context, "export.anyway", "Export anyway", "They are written as they are.")) {
    ExportCommand despite = command;
    despite.despite_findings = true;
    sink.Post(despite);
  }
}

void DrawResult(const FrameContext& context, const ExportCommand& command, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  if (!snapshot.exported) return;
  const ExportView& exported = *snapshot.exported;
  if (exported.running) return DimText("writing ...");
  if (exported.asks) return DrawQuestion(context, exported, sink);
  if (!exported.open_findings.empty()) {
    return DrawOpenFindings(context, exported, command, sink);
  }
  const bool good = exported.problem.empty();
  WrappedText(good ? colors::kGood : colors::kBad, good ? exported.done : exported.problem);
}

}  // namespace

void DrawExport(const FrameContext& context, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  const AnnotationSnapshot& snapshot = *context.annotation;
  const bool asks =
      snapshot.exported && (snapshot.exported->asks || !snapshot.exported->open_findings.empty());
  ImGui::BeginChild(
      "export", {context.Scaled(kSheetWidth), context.Scaled(asks ? kAskingHeight : kSheetHeight)});
  for (std::size_t i = 0; i < kExportFormats.size(); ++i) {
    if (i > 0) ImGui::SameLine(0, context.Scaled(3));
    if (ToggleWidth(context, kExportFormats[i].title) > ImGui::GetContentRegionAvail().x)
      ImGui::NewLine();
    bool on = view.export_format == i;
    if (Toggle(context, std::string("export.") + kExportFormats[i].name, kExportFormats[i].title,
               on, kExportFormats[i].what)) {
      view.export_format = i;
      view.export_out.clear();
    }
  }
  const ExportFormat& format = kExportFormats[view.export_format];
  ImGui::Dummy({0, context.Scaled(2)});
  WrappedText(colors::kText, format.what);
  WrappedText(colors::kAccent, format.conventions);
  ImGui::Dummy({0, context.Scaled(4)});
  DrawFrames(context, format);
  if (format.has_frames && snapshot.has_sequence) {
    Label(context, "Images");
    ImGui::TextUnformatted("every");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(context.Scaled(90));
    ImGui::InputInt("##export.every", &view.export_every);
    LogItem(context, "export.every");
    Tooltip(context, "1: every frame of the sequence; 10: every tenth.");
    view.export_every = std::clamp(view.export_every, 1, 100'000);
    ImGui::SameLine();
    DimText("of %d", snapshot.num_frames);
  }
  char path[512];
  std::snprintf(
      path, sizeof(path), "%s",
      view.export_out.empty() ? UsualPath(snapshot, format).c_str() : view.export_out.c_str());
  Label(context, "To");
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - BrowseWidth(context));
  ImGui::InputText("##export.out", path, sizeof(path));
  LogItem(context, "export.out");
  Tooltip(context,
          "A file or a folder, as the format has it. Where something else is there already, you "
          "are asked, and what is replaced is kept.");
  view.export_out = path;
  BrowseButton(context, "export.browse", [&] { return ExportQuestion(context, format); });
  ImGui::Dummy({0, context.Scaled(4)});
  const ExportCommand command{format.name, path, format.level ? view.export_frame : "scan",
                              view.export_every};
  const bool writing = snapshot.exported && (snapshot.exported->running || snapshot.exported->asks);
  ImGui::BeginDisabled(writing);
  ImGui::PushStyleColor(ImGuiCol_Button, colors::kAccentDim);
  if (Button(context, "export.write", "Export",
             asks ? "" : "Writes it now. The project does not change.")) {
    sink.Post(command);
  }
  ImGui::PopStyleColor();
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (Button(context, "export.close", "Close", "Esc closes it too.")) ImGui::CloseCurrentPopup();
  DrawResult(context, command, sink);
  ImGui::EndChild();
}

}  // namespace plumbline
