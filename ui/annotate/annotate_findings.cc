// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_findings.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

void GoTo(const FrameContext& context, int index, CommandSink& sink) {
  const auto& findings = context.annotation->checklist.findings;
  context.annotate->finding = index;
  const FindingView& finding = findings[static_cast<std::size_t>(index)];
  if (finding.instances.empty()) return;
  const std::string& id = finding.instances.front();
  if (context.annotation->Find(id) == nullptr) return;
  sink.Post(SelectInstanceCommand{id});
  context.annotate->focus_on = id;
}

/// Asks why it is all right; Enter says so without a reason, too.
void DrawAcceptance(const FrameContext& context, const FindingView& finding, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  if (!ImGui::BeginPopup("finding.why")) return;
  char note[256];
  std::snprintf(note, sizeof(note), "%s", view.finding_note.c_str());
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(context.Scaled(260));
  const bool entered = ImGui::InputTextWithHint("##finding.note", "why, if it needs saying", note,
                                                sizeof(note), ImGuiInputTextFlags_EnterReturnsTrue);
  LogItem(context, "finding.note");
  Tooltip(context, "For whoever reads the list later: \"stands on a box that was not scanned\".");
  view.finding_note = note;
  ImGui::SameLine(0, context.Scaled(6));
  if (Button(context, "finding.accept.done", "All right", "Enter does the same.") || entered) {
    sink.Post(AcceptFindingCommand{finding.kind, finding.instances, true, view.finding_note});
    view.finding_note.clear();
    --view.finding;  // the next one moves up to its place
    ImGui::CloseCurrentPopup();
  }
  if (ImGui::IsKeyReleased(ImGui::GetKeyIndex(ImGuiKey_Escape))) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

/// What can be done with the finding that is shown.
void DrawShown(const FrameContext& context, const FindingView& finding, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  if (!finding.can_accept || context.annotation->read_only) return;
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + context.Scaled(16));
  if (finding.accepted) {
    if (Button(context, "finding.reopen", "Open again",
               "It counts again, as something to be mended (O).")) {
      AcceptShownFinding(context, sink);
    }
    return;
  }
  const bool asked = std::exchange(view.accept_finding, false);
  if (Button(context, "finding.accept", "All right ...",
             "It is as it should be: it no longer counts, until one of its objects moves by more "
             "than 1 cm or 1\u00b0 (O).") ||
      asked) {
    ImGui::OpenPopup("finding.why");
  }
  ImGui::SetNextWindowPos({ImGui::GetItemRectMin().x, ImGui::GetItemRectMax().y});
  DrawAcceptance(context, finding, sink);
}

/// Who called it all right, and why.
std::string AcceptedBy(const FindingView& finding) {
  std::string text = "accepted";
  if (!finding.accepted_by.empty()) text += " by " + finding.accepted_by;
  if (!finding.accepted_note.empty()) text += ": " + finding.accepted_note;
  return text;
}

void DrawFinding(const FrameContext& context, int index, CommandSink& sink) {
  const FindingView& finding =
      context.annotation->checklist.findings[static_cast<std::size_t>(index)];
  const std::string name = fmt::format("finding.{}", index);
  const float width = ImGui::GetContentRegionAvail().x, margin = context.Scaled(6);
  const float text_x = context.Scaled(16);
  ImFont& font = *context.fonts.small;
  const float wrap = width - text_x - margin;
  const std::string sentence =
      finding.accepted ? finding.sentence + "\n" + AcceptedBy(finding) : finding.sentence;
  const ImVec2 text = font.CalcTextSizeA(font.FontSize, 1e6f, wrap, sentence.c_str());
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const ImVec2 size(width, text.y + 2 * margin);
  if (ImGui::Selectable(("##" + name).c_str(), context.annotate->finding == index, 0, size)) {
    GoTo(context, index, sink);
  }
  LogItem(context, name);
  Tooltip(context, finding.instances.empty() ? finding.kind
                                             : finding.kind + ": a click shows it (N: the next).");
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImVec2 center(low.x + context.Scaled(6), low.y + margin + 0.5f * font.FontSize);
  if (finding.accepted)
    draw.AddCircle(center, context.Scaled(3.5f), colors::kDimText);
  else
    draw.AddCircleFilled(center, context.Scaled(3.5f),
                         finding.error ? colors::kBad : colors::kWarning);
  draw.AddText(&font, font.FontSize, {low.x + text_x, low.y + margin},
               finding.accepted ? colors::kDimText : colors::kText, sentence.c_str(), nullptr,
               wrap);
  if (context.annotate->finding == index) DrawShown(context, finding, sink);
}

}  // namespace

void DrawFindings(const FrameContext& context, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  const ChecklistView& list = snapshot.checklist;
  if (snapshot.has_sequence) {
    ImGui::BeginDisabled(list.comparing);
    const std::string label =
        list.comparing ? fmt::format("Compared {} of {} ...", list.compared, list.to_compare)
                       : std::string("Compare all with the images");
    if (Button(context, "findings.compare", label.c_str(),
               "Adds the objects whose outlines lie on few edges of the images. Esc stops.")) {
      sink.Post(CompareAllCommand{});
    }
    ImGui::EndDisabled();
  }
  if (list.findings.empty()) {
    return EmptyState(context, "Nothing is wrong, as far as it shows",
                      "Tilted, floating, sunk, double and interpenetrating objects, and drafts "
                      "on top of others would be listed here.");
  }
  ImGui::BeginChild("findings", {0, 0});
  for (int i = 0; i < static_cast<int>(list.findings.size()); ++i) DrawFinding(context, i, sink);
  ImGui::EndChild();
}

void WalkFindings(const FrameContext& context, int step, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  view.check = true;
  const ChecklistView& list = context.annotation->checklist;
  const auto all = static_cast<int>(list.findings.size());
  const int open = all - list.NumAccepted();  // those that were accepted are the last
  const int count = open > 0 ? open : all;
  if (count == 0) return;
  const int from = view.finding < 0 && step < 0 ? 0 : view.finding;
  GoTo(context, ((from + step) % count + count) % count, sink);
}

const FindingView* ShownFinding(const FrameContext& context) {
  const auto& findings = context.annotation->checklist.findings;
  const int shown = context.annotate->finding;
  if (!context.annotate->check || shown < 0 || shown >= static_cast<int>(findings.size()))
    return nullptr;
  const FindingView& finding = findings[static_cast<std::size_t>(shown)];
  return finding.can_accept ? &finding : nullptr;
}

void AcceptShownFinding(const FrameContext& context, CommandSink& sink) {
  const FindingView& finding = *ShownFinding(context);
  if (!finding.accepted) {
    context.annotate->accept_finding = true;
    return;
  }
  sink.Post(AcceptFindingCommand{finding.kind, finding.instances, false, ""});
  context.annotate->finding = -1;
}

}  // namespace plumbline
