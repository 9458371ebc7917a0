// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/table_heads.h"

#include "ui/framework/widgets.h"

namespace plumbline {

void DrawTableHeads(const FrameContext& context, std::span<const TableHead> heads,
                    const std::string& log, int kept_columns) {
  ImGui::TableSetupScrollFreeze(kept_columns, 1);
  const float unit = context.fonts.small->FontSize;
  for (const TableHead& head : heads)
    ImGui::TableSetupColumn(head.name.c_str(), head.flags, head.width * unit);
  ImGui::TableNextRow(ImGuiTableRowFlags_Headers);
  for (std::size_t i = 0; i < heads.size(); ++i) {
    ImGui::TableSetColumnIndex(static_cast<int>(i));
    ImGui::PushStyleColor(ImGuiCol_Text, heads[i].color);
    ImGui::TableHeader(heads[i].name.c_str());
    ImGui::PopStyleColor();
    if (!log.empty()) LogItem(context, log + "." + std::to_string(i));
    Tooltip(context, heads[i].help);
  }
}

}  // namespace plumbline
