// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include "ui/annotate/annotate_panels.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kMenuWidth = 330;

void DrawMenuGroup(const FrameContext& context, const ActionGroup& group, CommandSink& sink) {
  for (const Action& action : group.actions) {
    if (!action.run || action.text.empty()) continue;
    if (action.is_offered && !action.is_offered(context)) continue;
    const bool on = action.is_on && action.is_on(context);
    const std::string& text = on ? action.text_when_on : action.text;
    const bool chosen = ImGui::Selectable(text.c_str(), false, 0, {context.Scaled(kMenuWidth), 0});
    LogItem(context, "menu." + action.text);
    if (!action.keys.empty()) {
      const std::string keys = NameOf(action.keys.front());
      ImGui::SameLine(context.Scaled(kMenuWidth) - ImGui::CalcTextSize(keys.c_str()).x);
      DimText("%s", keys.c_str());
    }
    if (chosen) action.run(context, sink);
  }
}

}  // namespace

void DrawAnnotateMenu(const FrameContext& context, std::span<const ActionGroup> groups,
                      CommandSink& sink) {
  const AnnotatedInstance* selected = context.annotation->Selected();
  const std::size_t more = context.annotate->also_selected.size();
  if (selected != nullptr && more == 0)
    SmallText(context, colors::kAccent, "%s", selected->id.c_str());
  if (selected != nullptr && more > 0)
    SmallText(context, colors::kAccent,
              "%s and %zu more: hiding, locking, grading and deleting are for all",
              selected->id.c_str(), more);
  bool first = true;
  for (const ActionGroup& group : groups) {
    const bool of_object = group.title == "Move" || group.title == "Align" || group.title == "Edit";
    const bool of_scan = group.title == "Place" || group.title == "Layers";
    if (selected != nullptr ? !of_object : !of_scan) continue;
    if (!first) ImGui::Separator();
    first = false;
    DrawMenuGroup(context, group, sink);
  }
}

}  // namespace plumbline
