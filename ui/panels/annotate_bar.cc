// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstring>

#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"
#include "ui/panels/annotate_panels.h"

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
  Tooltip(context, unsafe ? "Edits cannot be written to the disk: " + snapshot.journal_problem +
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
                "Takes the last edit back (Ctrl + Z)")) {
    sink.Post(UndoCommand{});
  }
  ImGui::SameLine(0, context.Scaled(6));
  const std::string redo = Capitalised("Redo", snapshot.redo_label);
  if (BarButton(context, "project.redo", redo.c_str(), snapshot.redo_label.has_value(),
                "Does it again (Ctrl + Shift + Z, Ctrl + Y)")) {
    sink.Post(RedoCommand{});
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
