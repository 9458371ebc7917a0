// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/relations_panel.h"

#include <fmt/format.h>

#include "engine/snapshot/map_snapshot.h"
#include "engine/snapshot/object_relation.h"
#include "ui/common/waiting.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

class RelationsPanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) {
      analysis_ = nullptr;
      return;
    }
    sink.Post(NeedCommand{NeedCommand::What::kRelations});
    if (context.analysis != nullptr && context.analysis->relations)
      analysis_ = context.analysis;  // until it is there, what was shown before stays
    if (analysis_ == nullptr || analysis_->relations->empty())
      return EmptyState(
          context, "No relations yet",
          "Relations are shown between confirmed objects: keep playing until there are two.");
    ImGui::PushFont(context.fonts.small);
    constexpr auto kFlags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                            ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_NoBordersInBody;
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {context.Scaled(6), context.Scaled(3.5)});
    if (ImGui::BeginTable("relations.table", 4, kFlags, ImGui::GetContentRegionAvail())) {
      for (std::size_t i = 0; i < analysis_->relations->size(); ++i) DrawRow(context, i, sink);
      ImGui::EndTable();
    }
    ImGui::PopStyleVar();
    ImGui::PopFont();
  }

 private:
  static std::string NameOf(const FrameContext& context, ObjectId id) {
    for (const ObjectReport& object : context.snapshot->report.objects) {
      if (object.id != id) continue;
      const ModelView* model = context.Model(object.label);
      return fmt::format("#{} {}", id.value, model != nullptr ? model->name : object.category);
    }
    return fmt::format("#{}", id.value);
  }

  void DrawRow(const FrameContext& context, std::size_t index, CommandSink& sink) const {
    const ObjectRelation& relation = (*analysis_->relations)[index];
    const std::string name = fmt::format("relations.row.{}", index);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    if (ImGui::Selectable(("##" + name).c_str(), relation.a == context.selection.object,
                          ImGuiSelectableFlags_SpanAllColumns))
      sink.Post(SelectObjectCommand{relation.a});
    LogItem(context, name);
    ImGui::SetCursorScreenPos(corner);
    Chip(context, relation.a);
    ImGui::TextUnformatted(NameOf(context, relation.a).c_str());
    ImGui::TableNextColumn();
    DimText("%s", RelationName(relation.kind));
    ImGui::TableNextColumn();
    Chip(context, relation.b);
    ImGui::TextUnformatted(NameOf(context, relation.b).c_str());
    ImGui::TableNextColumn();
    const std::string value = relation.kind == RelationKind::kHides
                                  ? fmt::format("{:.0f} %", 100 * relation.value)
                                  : fmt::format("{:.1f} cm", 100 * relation.value);
    ImGui::TextUnformatted(value.c_str());
    Tooltip(context, relation.kind == RelationKind::kHides
                         ? "Share of the second object's surface points in the picture that the "
                           "first one covers."
                         : "Smallest distance between the surfaces of the two models.");
  }

  std::shared_ptr<const FrameAnalysis> analysis_;  ///< With relations; null: none yet.
};

}  // namespace

std::unique_ptr<Panel> MakeRelationsPanel() { return std::make_unique<RelationsPanel>(); }

}  // namespace plumbline
