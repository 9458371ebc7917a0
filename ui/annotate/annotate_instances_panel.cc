// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "ui/annotate/annotate_agreement.h"
#include "ui/annotate/annotate_findings.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

class AnnotateInstancesPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    if (context.annotation == nullptr) return;
    const std::size_t count = context.annotation->instances.size();
    const std::string text = fmt::format("{} object{}", count, count == 1 ? "" : "s");
    const int errors = context.annotation->checklist.NumErrors();
    const std::string check = errors > 0 ? fmt::format("Check {}", errors) : "Check";
    const float gap = context.Scaled(8);
    AlignRight(
        context.fonts.small->CalcTextSizeA(context.fonts.small->FontSize, 1e6f, 0, text.c_str()).x +
        gap + ToggleWidth(context, check.c_str()));
    const float top = ImGui::GetCursorPosY();
    ImGui::SetCursorPosY(top + context.Scaled(3));
    SmallText(context, errors > 0 ? colors::kWarning : colors::kDimText, "%s", text.c_str());
    ImGui::SameLine(0, gap);
    ImGui::SetCursorPosY(top);
    Toggle(context, "annotate_instances.check", check.c_str(), context.annotate->check,
           "What is probably wrong, as a list to walk through (N, Shift + N).");
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    const AnnotationSnapshot& snapshot = *context.annotation;
    if (context.annotate->check) return DrawFindings(context, sink);
    if (snapshot.agreement) return DrawAgreement(context, sink);
    if (snapshot.instances.empty()) {
      return EmptyState(context, "Nothing is placed yet",
                        "Click a model above, then click in the scan where it stands.");
    }
    ImGui::BeginChild("instances", {0, 0});
    int number = 0;
    for (const AnnotatedInstance& instance : snapshot.instances) {
      DrawRow(context, instance, ++number, sink);
    }
    ImGui::EndChild();
  }

 private:
  static bool IsSelected(const FrameContext& context, const std::string& id) {
    const auto& also = context.annotate->also_selected;
    return context.annotation->selected == id ||
           std::find(also.begin(), also.end(), id) != also.end();
  }

  /// With Ctrl one more or one less, with Shift all up to there, else it alone.
  static void SelectRow(const FrameContext& context, const std::string& id, CommandSink& sink) {
    const ImGuiIO& io = ImGui::GetIO();
    const AnnotationSnapshot& snapshot = *context.annotation;
    auto& also = context.annotate->also_selected;
    if ((!io.KeyCtrl && !io.KeyShift) || snapshot.Selected() == nullptr) {
      also.clear();
      return sink.Post(SelectInstanceCommand{id});
    }
    if (id == snapshot.selected) return;
    if (io.KeyCtrl) {
      if (std::erase(also, id) == 0) also.push_back(id);
      return;
    }
    also.clear();
    bool within = false;
    for (const AnnotatedInstance& instance : snapshot.instances) {
      const bool end = instance.id == id || instance.id == snapshot.selected;
      if ((within || end) && instance.id != snapshot.selected) also.push_back(instance.id);
      if (end) within = !within;
    }
  }

  static void DrawRow(const FrameContext& context, const AnnotatedInstance& instance, int number,
                      CommandSink& sink) {
    const std::string name = "annotate_instances.row." + instance.id;
    const bool selected = IsSelected(context, instance.id);
    const float switches = context.Scaled(92);
    const ImVec2 low = ImGui::GetCursorScreenPos();
    const float line = ImGui::GetTextLineHeight() + context.Scaled(6);
    const float width = ImGui::GetContentRegionAvail().x;
    if (ImGui::Selectable(
            ("##" + name).c_str(), selected,
            ImGuiSelectableFlags_AllowDoubleClick | ImGuiSelectableFlags_AllowItemOverlap,
            {width, line})) {
      SelectRow(context, instance.id, sink);
      if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) context.annotate->focus = true;
    }
    LogItem(context, name);
    Tooltip(context,
            instance.note.empty() ? instance.model : instance.model + "\n" + instance.note);
    const float size = 0.62f * ImGui::GetTextLineHeight();
    const float middle = low.y + 0.5f * line;
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.AddRectFilled({low.x + context.Scaled(4), middle - 0.5f * size},
                       {low.x + context.Scaled(4) + size, middle + 0.5f * size},
                       SeriesColor(static_cast<std::size_t>(number - 1)), 0.2f * size);
    const ImU32 color = instance.hidden                                    ? colors::kFaint
                        : context.annotation->ModelOf(instance) == nullptr ? colors::kBad
                                                                           : colors::kText;
    draw.PushClipRect(low, {low.x + width - switches, low.y + line}, true);
    draw.AddText({low.x + context.Scaled(12) + size, middle - 0.5f * ImGui::GetFontSize()}, color,
                 instance.id.c_str());
    draw.PopClipRect();
    DrawSwitches(context, instance, {low.x + width - switches, low.y}, line, sink);
    ImGui::SetCursorScreenPos({low.x, low.y + line + context.Scaled(2)});
    ImGui::Dummy({0, 0});
  }

  static void DrawSwitches(const FrameContext& context, const AnnotatedInstance& instance,
                           ImVec2 at, float line, CommandSink& sink) {
    const auto word = [&](float x, float width, const char* id, const char* text, bool on,
                          const char* help) {
      ImGui::SetCursorScreenPos({at.x + context.Scaled(x), at.y});
      const std::string name = std::string("annotate_instances.") + id + "." + instance.id;
      const bool clicked = ImGui::InvisibleButton(name.c_str(), {context.Scaled(width), line});
      LogItem(context, name);
      Tooltip(context, help);
      const bool hovered = ImGui::IsItemHovered();
      ImFont& font = *context.fonts.small;
      ImGui::GetWindowDrawList()->AddText(
          &font, font.FontSize, {at.x + context.Scaled(x), at.y + 0.5f * (line - font.FontSize)},
          on        ? colors::kText
          : hovered ? colors::kDimText
                    : colors::kFaint,
          text);
      return clicked;
    };
    ChangeInstanceCommand change;
    change.id = instance.id;
    if (IsSelected(context, instance.id)) {
      change.and_also = context.annotate->also_selected;
      change.and_also.push_back(context.annotation->selected);
      std::erase(change.and_also, instance.id);
    }
    if (word(0, 24, "quality", instance.fine ? "fine" : "crs", instance.fine,
             "Quality: fine, or coarse. A click changes it.")) {
      change.set.fine = !instance.fine;
      sink.Post(change);
    }
    if (word(30, 28, "hide", "hide", instance.hidden, "Hidden or not (H).")) {
      change.set.hidden = !instance.hidden;
      sink.Post(change);
    }
    if (word(62, 28, "lock", "lock", instance.locked,
             "A locked object cannot be moved, renamed or removed (L).")) {
      change.set.locked = !instance.locked;
      sink.Post(change);
    }
  }
};

}  // namespace

std::unique_ptr<Panel> MakeAnnotateInstancesPanel() {
  return std::make_unique<AnnotateInstancesPanel>();
}

}  // namespace plumbline
