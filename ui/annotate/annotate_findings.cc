// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_findings.h"

#include <fmt/format.h>

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

void DrawFinding(const FrameContext& context, int index, CommandSink& sink) {
  const FindingView& finding =
      context.annotation->checklist.findings[static_cast<std::size_t>(index)];
  const std::string name = fmt::format("finding.{}", index);
  const float width = ImGui::GetContentRegionAvail().x, margin = context.Scaled(6);
  const float text_x = context.Scaled(16);
  ImFont& font = *context.fonts.small;
  const float wrap = width - text_x - margin;
  const ImVec2 text = font.CalcTextSizeA(font.FontSize, 1e6f, wrap, finding.sentence.c_str());
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const ImVec2 size(width, text.y + 2 * margin);
  if (ImGui::Selectable(("##" + name).c_str(), context.annotate->finding == index, 0, size)) {
    GoTo(context, index, sink);
  }
  LogItem(context, name);
  Tooltip(context, finding.instances.empty() ? finding.kind
                                             : finding.kind + ": a click shows it (N: the next).");
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddCircleFilled({low.x + context.Scaled(6), low.y + margin + 0.5f * font.FontSize},
                       context.Scaled(3.5f), finding.error ? colors::kBad : colors::kWarning);
  draw.AddText(&font, font.FontSize, {low.x + text_x, low.y + margin}, colors::kText,
               finding.sentence.c_str(), nullptr, wrap);
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
  const auto count = static_cast<int>(context.annotation->checklist.findings.size());
  if (count == 0) return;
  const int from = view.finding < 0 && step < 0 ? 0 : view.finding;
  GoTo(context, ((from + step) % count + count) % count, sink);
}

}  // namespace plumbline
