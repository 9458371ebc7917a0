// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/objects_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/snapshot/truths_view.h"
#include "ui/common/waiting.h"
#include "ui/files/kept_value.h"
#include "ui/framework/table_heads.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kNarrowest = 790;  ///< Narrower than this the table scrolls sideways.

struct ObjectColumn {
  const char* name;
  float width;  ///< As of TableHead; 0: takes what is left.
  const char* help;
};

std::vector<TableHead> HeadsOf(std::span<const ObjectColumn> columns) {
  std::vector<TableHead> heads;
  for (const ObjectColumn& column : columns) {
    const ImGuiTableColumnFlags flags =
        column.width > 0 ? ImGuiTableColumnFlags_WidthFixed : ImGuiTableColumnFlags_WidthStretch;
    heads.push_back({column.name, column.help, flags, column.width});
  }
  return heads;
}

constexpr ObjectColumn kObjectColumns[] = {
    {"Object", 4.4f,
     "Number in the order in which objects were spawned, and the colour that the object has "
     "everywhere."},
    {"Category", 6.0f, "The detector's category (COCO name)."},
    {"Model", 0.0f, "Most likely shape, and its probability."},
    {"State", 5.6f,
     "Tentative until the evidence suffices, then confirmed; retired when it speaks against the "
     "object."},
    {"P(there)", 4.6f, "Probability that the object exists, from its accumulated evidence."},
    {"Position", 5.2f,
     "Standard deviation of the position, of all hypotheses: root of the sum over three axes."},
    {"Azimuth", 4.6f, "Standard deviation of the azimuth about up, of all hypotheses."},
    {"Visible", 4.2f,
     "Share of the mean contour that shows in this image. Dim: not updated in this frame."},
    {"\u03a6 det", 3.6f, "Detector term of the score at the mean state, 0 to 1."},
    {"\u03a6 edge", 3.9f, "Edge term of the score at the mean state."},
};

void TextRight(ImU32 color, const std::string& text) {
  const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(text.c_str()).x;
  if (room > 0) ImGui::SetCursorPosX(ImGui::GetCursorPosX() + room);
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopStyleColor();
}

class ObjectsPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    if (context.snapshot == nullptr) return;
    int confirmed = 0, tentative = 0;
    for (const ObjectReport& object : context.snapshot->report.objects) {
      confirmed += object.state == ObjectState::kConfirmed;
      tentative += object.state == ObjectState::kTentative;
    }
    const std::string text = fmt::format("{} confirmed, {} tentative", confirmed, tentative);
    const float width =
        context.fonts.small->CalcTextSizeA(context.fonts.small->FontSize, 1e6f, 0, text.c_str()).x;
    if (AnyMissed(context)) {
      const std::string label = fmt::format("{} missed", context.truths->missed);
      AlignRight(width + ToggleWidth(context, label.c_str()) + context.Scaled(8));
      Toggle(context, "objects.missed", label.c_str(), missed_,
             "The true objects that the run, as far as it goes, has not found, and why. A click on "
             "one tells more under 'Why here?'.");
      ImGui::SameLine(0, context.Scaled(8));
    } else {
      AlignRight(width);
    }
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + context.Scaled(3));
    SmallText(context, colors::kDimText, "%s", text.c_str());
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const bool shows_missed = missed_ && AnyMissed(context);
    if (context.snapshot->report.objects.empty() && !shows_missed) {
      return EmptyState(
          context, "No objects yet",
          "The first are spawned from the detector's proposals: press Space to play on.");
    }
    ImGui::PushFont(context.fonts.small);
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {context.Scaled(6), context.Scaled(3.5)});
    if (shows_missed)
      DrawMissed(context, sink);
    else
      DrawObjects(context, sink);
    ImGui::PopStyleVar();
    ImGui::PopFont();
  }

  nlohmann::json SaveState() const override { return {{"missed", missed_}}; }
  void LoadState(const nlohmann::json& json) override {
    missed_ = KeptValue(json, "missed", missed_);
  }

 private:
  static bool AnyMissed(const FrameContext& context) {
    return context.truths != nullptr && context.truths->missed > 0;
  }

  static void DrawObjects(const FrameContext& context, CommandSink& sink) {
    const bool scrolls = ImGui::GetContentRegionAvail().x < context.Scaled(kNarrowest);
    const ImGuiTableFlags flags =
        (scrolls ? ImGuiTableFlags_ScrollX : 0) | ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
        ImGuiTableFlags_Resizable | ImGuiTableFlags_Hideable | ImGuiTableFlags_NoBordersInBody;
    if (ImGui::BeginTable("objects.table", static_cast<int>(std::size(kObjectColumns)), flags,
                          ImGui::GetContentRegionAvail(),
                          scrolls ? context.Scaled(kNarrowest) : 0.0f)) {
      DrawTableHeads(context, HeadsOf(kObjectColumns), "", 1);
      for (const ObjectReport& object : context.snapshot->report.objects) {
        if (context.Shows(object)) DrawRow(context, object, sink);
      }
      ImGui::EndTable();
    }
  }

  static void DrawRow(const FrameContext& context, const ObjectReport& object, CommandSink& sink) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    const ImVec2 cursor = ImGui::GetCursorScreenPos();
    const std::string name = fmt::format("objects.row.{}", object.id.value);
    const bool selected = object.id == context.selection.object;
    if (ImGui::Selectable(
            ("##" + name).c_str(), selected,
            ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowDoubleClick)) {
      sink.Post(SelectObjectCommand{object.id});
      if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) sink.Post(FocusSelectionCommand{});
    }
    LogItem(context, name);
    ImGui::SetCursorScreenPos(cursor);
    Chip(context, object.id);
    ImGui::Text("#%d", object.id.value);
    DrawCells(context, object);
  }

  /// The true objects that the run, as far as it goes, has not found.
  static void DrawMissed(const FrameContext& context, CommandSink& sink) {
    static constexpr ObjectColumn kColumns[] = {
        {"Missed", 7.5f, "True objects that the run, as far as it goes, has not found."},
        {"Model", 7.5f, "Its true shape."},
        {"Why", 0, "What kept it out. Click a row, and 'Why here?' tells more."},
        {"Seen", 4.0f, "Frames in which enough of it shows."},
        {"Boxed", 4.0f, "Those of them in which a box of its category lies over it."}};
    if (!ImGui::BeginTable("objects.missed", static_cast<int>(std::size(kColumns)),
                           ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                               ImGuiTableFlags_Resizable | ImGuiTableFlags_NoBordersInBody))
      return;
    std::vector<TableHead> heads = HeadsOf(kColumns);
    heads[0].name =
        fmt::format("Missed {} of {}", context.truths->missed, context.truths->truths.size());
    heads[0].color = colors::kWarning;
    DrawTableHeads(context, heads);
    for (const TruthView& truth : context.truths->truths) {
      if (!truth.found) DrawMissedRow(context, truth, sink);
    }
    ImGui::EndTable();
  }

  static void DrawMissedRow(const FrameContext& context, const TruthView& truth,
                            CommandSink& sink) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    const std::string name = "objects.truth." + truth.id;
    if (ImGui::Selectable(
            ("##" + name).c_str(), truth.id == context.selection.truth,
            ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowDoubleClick)) {
      sink.Post(SelectTruthCommand{truth.id});
      sink.Post(ShowPanelCommand{"why"});
      if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) sink.Post(FocusSelectionCommand{});
    }
    LogItem(context, name);
    Tooltip(context, truth.text);
    ImGui::SameLine(0, 0);
    ImGui::PushStyleColor(ImGuiCol_Text, OnPanel(colors::kTruth));
    ImGui::TextUnformatted(truth.id.c_str());
    ImGui::PopStyleColor();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(truth.model.c_str());
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(truth.text.c_str());
    ImGui::TableNextColumn();
    TextRight(colors::kText, std::to_string(truth.frames_seen));
    ImGui::TableNextColumn();
    TextRight(colors::kText, std::to_string(truth.frames_boxed));
  }

  static void DrawCells(const FrameContext& context, const ObjectReport& object) {
    const ModelView* model = context.Model(object.label);
    const double label =
        object.label_probability.empty() ? 0 : object.label_probability.front().probability;
    const double there = 1 / (1 + std::exp(-object.log_evidence));
    const ObjectSpread* spread = context.SpreadOf(object.id);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(object.category.c_str());
    ImGui::TableNextColumn();
    ImGui::Text("%s", model != nullptr ? model->name.c_str() : "?");
    ImGui::SameLine();
    DimText("%.0f %%", 100 * label);
    if (object.modes.size() > 1) {
      ImGui::SameLine();
      ImGui::PushStyleColor(ImGuiCol_Text, colors::kWarning);
      ImGui::Text("%zu modes", object.modes.size());
      ImGui::PopStyleColor();
      Tooltip(context,
              "The hypotheses form clearly separate clusters; select the object to see them.");
    }
    ImGui::TableNextColumn();
    ImGui::PushStyleColor(ImGuiCol_Text, StateColor(object.state));
    ImGui::TextUnformatted(NameOf(object.state).data());
    ImGui::PopStyleColor();
    ImGui::TableNextColumn();
    TextRight(colors::kText, fmt::format("{:.0f} %", 100 * there));
    ImGui::TableNextColumn();
    TextRight(colors::kText, spread == nullptr
                                 ? ".."
                                 : fmt::format("\u00b1 {:.1f} cm", 100 * spread->position_std_m));
    ImGui::TableNextColumn();
    if (model != nullptr && model->any_azimuth) {
      TextRight(colors::kFaint, "round");
      Tooltip(context, "The model looks the same from all sides.");
    } else {
      TextRight(colors::kText,
                spread == nullptr || !spread->azimuth_std_rad
                    ? ".."
                    : fmt::format("\u00b1 {:.1f}\u00b0", kDegPerRad * *spread->azimuth_std_rad));
    }
    const ImU32 seen = object.updated ? colors::kText : colors::kFaint;
    ImGui::TableNextColumn();
    TextRight(seen, fmt::format("{:.0f} %", 100 * object.visible_fraction));
    ImGui::TableNextColumn();
    TextRight(seen, fmt::format("{:.2f}", object.phi_cnn));
    ImGui::TableNextColumn();
    TextRight(seen, fmt::format("{:.2f}", object.phi_edge));
  }

  bool missed_ = false;  ///< Shows those instead.
};

}  // namespace

ActionGroup SelectionActions() {
  return {"Selection",
          {{.text = "Clear the selection",
            .keys = {{keys::kEscape}},
            .run = Posts(SelectObjectCommand{}),
            .help_keys = "Esc",
            .help = "Clear the selection",
            .is_offered = [](const FrameContext& context) { return !context.help_shown; }}}};
}

std::unique_ptr<Panel> MakeObjectsPanel() { return std::make_unique<ObjectsPanel>(); }

}  // namespace plumbline
