// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <utility>

#include "ui/annotate/annotate_agreement.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kSteadyWidth = 150, kNarrowWidth = 84;
constexpr double kSheetRoom = 500;  ///< For the sheets of Export and More.
constexpr double kNarrowBar = 820;  ///< Below it, undo and redo leave their room to the others.

std::string Capitalised(const char* word, const std::optional<std::string>& label) {
  return label ? std::string(word) + ": " + *label : std::string(word);
}

/// A button that says what it would do, dim while it would do nothing.
bool BarButton(const FrameContext& context, const char* name, const char* label, bool enabled,
               const std::string& tooltip) {
  ImGui::BeginDisabled(!enabled);
  const bool clicked = Button(context, name, label, tooltip);
  ImGui::EndDisabled();
  return clicked && enabled;
}

/// The same, as wide whatever it says: buttons stay where they are. The tooltip tells what does
/// not fit.
bool SteadyButton(const FrameContext& context, const char* name, std::string label, float width,
                  bool enabled, const std::string& tooltip) {
  const ImVec2 size(width, 0);
  const float room = size.x - 2 * ImGui::GetStyle().FramePadding.x;
  if (ImGui::CalcTextSize(label.c_str()).x > room) {
    constexpr const char* kMore = "\u2026";
    const auto is_inner_byte = [](char c) { return (c & 0xC0) == 0x80; };  // of UTF-8
    while (!label.empty() && ImGui::CalcTextSize((label + kMore).c_str()).x > room) {
      while (is_inner_byte(label.back())) label.pop_back();
      label.pop_back();
    }
    label += kMore;
  }
  ImGui::BeginDisabled(!enabled);
  const bool clicked = ImGui::Button((label + "###" + name).c_str(), size);
  ImGui::EndDisabled();
  LogItem(context, name);
  Tooltip(context, tooltip);
  return clicked && enabled;
}

PathQuestion SaveAsQuestion(const std::string& at) {
  return {.what = PathQuestion::What::kSave,
          .title = "Save the project as",
          .button = "Save",
          .kinds = {PathKind::kProject},
          .at = at,
          .ending = ".json",
          .answer = [](const std::string& path, CommandSink& sink) {
            sink.Post(SaveProjectCommand{path});
          }};
}

/// A line for a path or a name, and a button that does something with it.
bool PathField(const FrameContext& context, const char* name, const char* hint, char* text,
               std::size_t size, const char* button, const char* help,
               const std::function<PathQuestion()>& question) {
  ImGui::SetNextItemWidth(context.Scaled(330));
  const std::string field = std::string(name) + ".field";
  const bool entered = ImGui::InputTextWithHint(("##" + field).c_str(), hint, text, size,
                                                ImGuiInputTextFlags_EnterReturnsTrue);
  LogItem(context, field);
  Tooltip(context, help);
  BrowseButton(context, std::string(name) + ".browse", question);
  ImGui::SameLine(0, context.Scaled(6));
  const bool clicked = Button(context, name, button, help);
  return (entered || clicked) && *text != '\0';
}

/// Where the edits are, in one truth: on the disk they always are.
struct SavedState {
  const char* label;
  ImU32 color;
  std::string help;
};

SavedState SavedStateOf(const AnnotationSnapshot& snapshot) {
  if (snapshot.read_only)
    return {"read only", colors::kWarning, "Somebody else has it open; Save as makes a copy."};
  if (!snapshot.journal_problem.empty()) {
    return {"NOT ON DISK", colors::kBad,
            "Edits cannot be written to disk: " + snapshot.journal_problem +
                ". They are kept in memory; Save as puts them elsewhere."};
  }
  if (snapshot.modified) {
    return {"kept", colors::kDimText,
            "Every edit is on disk, in the journal beside the project. The project's file gets "
            "them when you save (Ctrl + S), open something else or quit."};
  }
  return {"saved", colors::kFaint, "The project's file has every edit."};
}

void DrawMore(const FrameContext& context, CommandSink& sink) {
  static constexpr std::size_t kLongest = 512;
  struct Fields {
    char save_as[kLongest], run[kLongest], second[kLongest], annotator[96];
  };
  AnnotateView& view = *context.annotate;
  const AnnotationSnapshot& snapshot = *context.annotation;
  Fields fields{};
  const auto fill = [](char* to, std::size_t size, const std::string& from) {
    std::snprintf(to, size, "%s", from.c_str());
  };
  fill(fields.save_as, kLongest, view.save_as.empty() ? snapshot.project_file : view.save_as);
  fill(fields.run, kLongest, view.run);
  fill(fields.second, kLongest, view.second);
  fill(fields.annotator, sizeof(fields.annotator), snapshot.annotator);
  SmallText(context, colors::kAccent, "Save as");
  if (PathField(
          context, "more.save_as", "PROJECT.json", fields.save_as, kLongest, "Save",
          "Continues in this file, which is overwritten; paths to scan and models are made to "
          "fit.",
          [&] { return SaveAsQuestion(fields.save_as); })) {
    sink.Post(SaveProjectCommand{fields.save_as});
    ImGui::CloseCurrentPopup();
  }
  view.save_as = fields.save_as;
  ImGui::Dummy({0, context.Scaled(4)});
  SmallText(context, colors::kAccent, "Drafts");
  if (PathField(context, "more.drafts", "RUN.plb", fields.run, kLongest, "Take",
                "The objects of a run come in as coarse ones, to be mended or removed. One edit.",
                [&] {
                  return PathQuestion{.title = "Take the objects of a run",
                                      .button = "Take",
                                      .kinds = {PathKind::kRun},
                                      .at = fields.run,
                                      .answer = [](const std::string& path, CommandSink& to) {
                                        to.Post(ImportDraftsCommand{path});
                                      }};
                })) {
    sink.Post(ImportDraftsCommand{fields.run});
    ImGui::CloseCurrentPopup();
  }
  view.run = fields.run;
  ImGui::Dummy({0, context.Scaled(4)});
  SmallText(context, colors::kAccent, "Compare with");
  if (PathField(context, "more.compare", "PROJECT.json or ground_truth.json", fields.second,
                kLongest, "Compare",
                "What another annotator placed in this scan, object by object, in the list of what "
                "is placed. Nothing is changed.",
                [&] { return AgreementQuestion(view); })) {
    CompareWith(fields.second, view, sink);
    ImGui::CloseCurrentPopup();
  }
  view.second = fields.second;
  ImGui::Dummy({0, context.Scaled(4)});
  SmallText(context, colors::kAccent, "Annotator");
  ImGui::SetNextItemWidth(context.Scaled(200));
  if (ImGui::InputText("##more.annotator", fields.annotator, sizeof(fields.annotator))) {
    sink.Post(SetAnnotatorCommand{fields.annotator});
  }
  LogItem(context, "more.annotator");
  Tooltip(context, "Your name: it is kept with everything that you place.");
}

}  // namespace

void DrawProjectBar(const FrameContext& context, const LayoutRect& rect, CommandSink& sink) {
  if (context.annotation == nullptr || context.annotation->project_file.empty()) return;
  const AnnotationSnapshot& snapshot = *context.annotation;
  const float middle = 0.5f * (rect.low.y + rect.high.y);
  const float row = ImGui::GetFrameHeight();
  ImGui::PushClipRect(rect.low, rect.high, true);
  ImGui::SetCursorScreenPos({rect.low.x, middle - 0.5f * row});
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(snapshot.project_name.c_str());
  LogItem(context, "project.name");
  Tooltip(context, snapshot.project_file);
  ImGui::SameLine(0, context.Scaled(8));
  ImGui::AlignTextToFramePadding();
  const SavedState state = SavedStateOf(snapshot);
  const float after_state = ImGui::GetCursorPosX() + ImGui::CalcTextSize("NOT ON DISK").x;
  ImGui::PushStyleColor(ImGuiCol_Text, state.color);
  ImGui::TextUnformatted(state.label);
  ImGui::PopStyleColor();
  LogItem(context, "project.state");
  Tooltip(context, state.help);
  ImGui::SameLine(after_state + context.Scaled(14));
  if (BarButton(context, "project.save", "Save", snapshot.modified && !snapshot.read_only,
                "Writes the project (Ctrl + S)")) {
    sink.Post(SaveProjectCommand{});
  }
  ImGui::SameLine(0, context.Scaled(6));
  const bool narrow = rect.width() < context.Scaled(kNarrowBar);
  const float steady = context.Scaled(narrow ? kNarrowWidth : kSteadyWidth);
  const std::string undo = Capitalised("Undo", snapshot.undo_label);
  if (SteadyButton(context, "project.undo", undo, steady, snapshot.undo_label.has_value(),
                   undo + " (Ctrl + Z)")) {
    sink.Post(UndoCommand{});
  }
  ImGui::SameLine(0, context.Scaled(6));
  const std::string redo = Capitalised("Redo", snapshot.redo_label);
  if (SteadyButton(context, "project.redo", redo, steady, snapshot.redo_label.has_value(),
                   redo + " (Ctrl + Shift + Z, Ctrl + Y)")) {
    sink.Post(RedoCommand{});
  }
  ImGui::SameLine(0, context.Scaled(6));
  const bool has_content = !snapshot.instances.empty() || snapshot.num_fragments > 0;
  if (BarButton(context, "project.export", "Export", has_content,
                has_content ? "Writes the annotations in other formats (Ctrl + E)"
                            : "There is nothing to export yet: place an object or cut one out") ||
      (std::exchange(context.annotate->open_export, false) && has_content)) {
    ImGui::OpenPopup("project.export");
  }
  const float end = ImGui::GetIO().DisplaySize.x - context.Scaled(8);
  ImGui::SetNextWindowPos(
      {std::min(ImGui::GetItemRectMin().x, end - context.Scaled(kSheetRoom)), rect.high.y});
  if (ImGui::BeginPopup("project.export")) {
    DrawExport(context, sink);
    // As it goes up: while it goes down the sheet is open, and the key does nothing else.
    if (ImGui::IsKeyReleased(ImGui::GetKeyIndex(ImGuiKey_Escape))) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  }
  ImGui::SameLine(0, context.Scaled(6));
  if (Button(context, "project.queue", "Queue",
             "The scans of a folder and how far each is; hand this one over for review, or say "
             "that it is done (Ctrl + Shift + O).") ||
      std::exchange(context.annotate->open_queue, false)) {
    ImGui::OpenPopup("project.queue");
    sink.Post(ListQueueCommand{});
  }
  ImGui::SetNextWindowPos(
      {std::min(ImGui::GetItemRectMin().x, end - QueueWidth(context)), rect.high.y});
  if (ImGui::BeginPopup("project.queue")) {
    DrawQueue(context, sink);
    // As it goes up: while it goes down the sheet is open, and the key does nothing else.
    if (ImGui::IsKeyReleased(ImGui::GetKeyIndex(ImGuiKey_Escape))) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  }
  ImGui::SameLine(0, context.Scaled(6));
  if (Button(context, "project.more", "More", "Save as, drafts from a run, your name.") ||
      std::exchange(context.annotate->open_more, false)) {
    ImGui::OpenPopup("project.more");
  }
  ImGui::SetNextWindowPos(
      {std::min(ImGui::GetItemRectMin().x, end - context.Scaled(kSheetRoom)), rect.high.y});
  if (ImGui::BeginPopup("project.more")) {
    DrawMore(context, sink);
    // As it goes up: while it goes down the sheet is open, and the key does nothing else.
    if (ImGui::IsKeyReleased(ImGui::GetKeyIndex(ImGuiKey_Escape))) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  }
  ImGui::PopClipRect();
}

std::string AnnotationStatus(const FrameContext& context, bool& bad) {
  bad = false;
  if (context.annotation == nullptr) return "Nothing is open.";
  const AnnotationSnapshot& snapshot = *context.annotation;
  if (snapshot.state == AnnotationSnapshot::State::kFailed) {
    bad = true;
    return snapshot.failure;
  }
  if (!snapshot.busy.empty()) return snapshot.busy + " ...";
  if (!snapshot.answer.empty()) {
    bad = snapshot.refused;
    return snapshot.answer;
  }
  return fmt::format("{} points, {} models, {} objects.", snapshot.scan_points,
                     snapshot.models->size(), snapshot.instances.size());
}

}  // namespace plumbline
