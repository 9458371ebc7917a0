// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>

#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

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

/// A line for a path or a name, and a button that does something with it.
bool PathField(const FrameContext& context, const char* name, const char* hint, char* text,
               std::size_t size, const char* button, const char* help) {
  ImGui::SetNextItemWidth(context.Scaled(330));
  const std::string field = std::string(name) + ".field";
  const bool entered = ImGui::InputTextWithHint(("##" + field).c_str(), hint, text, size,
                                                ImGuiInputTextFlags_EnterReturnsTrue);
  LogItem(context, field);
  Tooltip(context, help);
  ImGui::SameLine(0, context.Scaled(6));
  const bool clicked = Button(context, name, button, help);
  return (entered || clicked) && *text != '\0';
}

void DrawMore(const FrameContext& context, CommandSink& sink) {
  static constexpr std::size_t kLongest = 512;
  struct Fields {
    char save_as[kLongest], run[kLongest], annotator[96];
  };
  AnnotateView& view = *context.annotate;
  const AnnotationSnapshot& snapshot = *context.annotation;
  Fields fields{};
  const auto fill = [](char* to, std::size_t size, const std::string& from) {
    std::snprintf(to, size, "%s", from.c_str());
  };
  fill(fields.save_as, kLongest, view.save_as.empty() ? snapshot.project_file : view.save_as);
  fill(fields.run, kLongest, view.run);
  fill(fields.annotator, sizeof(fields.annotator), snapshot.annotator);
  SmallText(context, colors::kAccent, "Save as");
  if (PathField(
          context, "more.save_as", "PROJECT.json", fields.save_as, kLongest, "Save",
          "Continues in this file, which is overwritten; paths to scan and models are made to "
          "fit.")) {
    sink.Post(SaveProjectCommand{fields.save_as});
    ImGui::CloseCurrentPopup();
  }
  view.save_as = fields.save_as;
  ImGui::Dummy({0, context.Scaled(4)});
  SmallText(context, colors::kAccent, "Drafts");
  if (PathField(
          context, "more.drafts", "RUN.plb", fields.run, kLongest, "Take",
          "The objects of a run come in as coarse ones, to be mended or removed. One edit.")) {
    sink.Post(ImportDraftsCommand{fields.run});
    ImGui::CloseCurrentPopup();
  }
  view.run = fields.run;
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
  const bool unsafe = !snapshot.journal_problem.empty();
  ImGui::PushStyleColor(ImGuiCol_Text, unsafe              ? colors::kBad
                                       : snapshot.modified ? colors::kWarning
                                                           : colors::kFaint);
  ImGui::TextUnformatted(snapshot.read_only  ? "read only"
                         : unsafe            ? "NOT SAFE ON DISK"
                         : snapshot.modified ? "not saved"
                                             : "saved");
  ImGui::PopStyleColor();
  LogItem(context, "project.state");
  Tooltip(context, unsafe ? "Edits cannot be written to disk: " + snapshot.journal_problem +
                                ". They are kept in memory; Save as puts them elsewhere."
                          : "Every edit is in the journal beside the project at once; what is not "
                            "saved comes back after a crash.");
  ImGui::SameLine(0, context.Scaled(18));
  if (BarButton(context, "project.save", "Save", snapshot.modified && !snapshot.read_only,
                "Writes the project (Ctrl + S)")) {
    sink.Post(SaveProjectCommand{});
  }
  ImGui::SameLine(0, context.Scaled(6));
  const std::string undo = Capitalised("Undo", snapshot.undo_label);
  if (BarButton(context, "project.undo", undo.c_str(), snapshot.undo_label.has_value(),
                "Undoes the last edit (Ctrl + Z)")) {
    sink.Post(UndoCommand{});
  }
  ImGui::SameLine(0, context.Scaled(6));
  const std::string redo = Capitalised("Redo", snapshot.redo_label);
  if (BarButton(context, "project.redo", redo.c_str(), snapshot.redo_label.has_value(),
                "Redoes the edit that was undone (Ctrl + Shift + Z, Ctrl + Y)")) {
    sink.Post(RedoCommand{});
  }
  ImGui::SameLine(0, context.Scaled(6));
  const bool has_content = !snapshot.instances.empty() || snapshot.num_fragments > 0;
  if (BarButton(context, "project.export", "Export", has_content,
                has_content ? "Writes the annotations in other formats"
                            : "There is nothing to export yet: place an object or cut one out")) {
    ImGui::OpenPopup("project.export");
  }
  ImGui::SetNextWindowPos({ImGui::GetItemRectMin().x, rect.high.y});
  if (ImGui::BeginPopup("project.export")) {
    DrawExport(context, sink);
    if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  }
  ImGui::SameLine(0, context.Scaled(6));
  if (Button(context, "project.more", "More", "Save as, drafts from a run, your name."))
    ImGui::OpenPopup("project.more");
  ImGui::SetNextWindowPos({ImGui::GetItemRectMin().x, rect.high.y});
  if (ImGui::BeginPopup("project.more")) {
    DrawMore(context, sink);
    if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) ImGui::CloseCurrentPopup();
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
