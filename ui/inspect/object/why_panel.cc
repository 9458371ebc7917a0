// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/why_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/geometry/angle_text.h"
#include "ui/common/waiting.h"
#include "ui/files/kept_value.h"
#include "ui/framework/table_heads.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/image/overlays.h"
#include "ui/inspect/object/likelihood_maps.h"
#include "ui/inspect/truth/missed_view.h"
#include "ui/inspect/truth/truths.h"

namespace plumbline {
namespace {

class WhyPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    AlignRight(ToggleWidth(context, "Two at once") + ToggleWidth(context, "Reference") +
               context.Scaled(4));
    if (Toggle(context, "why.maps", "Two at once", maps_,
               "Sweeps two parameters at once: colours show where the score is high."))
      asked_version_ = 0;
    ImGui::SameLine();
    if (Toggle(context, "why.reference", "Reference", reference_,
               "Also by the reference scorer, which renders every hypothesis. It takes longer."))
      asked_version_ = 0;
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const TruthView* truth = SelectedTruth(context);
    if (context.SelectedObject() == nullptr && truth == nullptr) {
      return EmptyState(context, "No object selected",
                        "Select one that is in this frame, or a true one that was missed (in "
                        "Objects); then it is explained here.");
    }
    Ask(context, sink);
    const ProbeView* probe = ProbeOfSelection(context);
    if (truth != nullptr) return DrawTruth(context, *truth, probe, sink);
    if (probe == nullptr) {
      return context.playback->state == PlaybackState::kPlaying
                 ? EmptyState(context, "Playing", "Pause, and the scores are explained here.")
                 : EmptyState(context, "Scoring", "This takes a moment, the first time longer.");
    }
    if (!probe->message.empty())
      return EmptyState(context, "Nothing to score", probe->message.c_str());
    ImGui::PushFont(context.fonts.small);
    DrawVerdict(*probe);
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const bool beside = room.x > context.Scaled(620);
    const float width = beside ? 0.56f * room.x : room.x;
    ImGui::BeginChild("why.table", {width, beside ? room.y : 0.5f * room.y});
    DrawTable(context, *probe, sink);
    ImGui::EndChild();
    if (beside) ImGui::SameLine(0, context.Scaled(10));
    if (maps_)
      DrawLikelihoodMaps(context, *probe, term_);
    else
      DrawSlices(context, *probe);
    ImGui::PopFont();
  }

  nlohmann::json SaveState() const override {
    return {{"reference", reference_}, {"maps", maps_}, {"term", term_}};
  }
  void LoadState(const nlohmann::json& json) override {
    reference_ = KeptValue(json, "reference", reference_);
    maps_ = KeptValue(json, "maps", maps_);
    term_ = KeptValue(json, "term", term_);
  }

 private:
  /// Once for every frame, object and marked particle, not while it plays.
  void Ask(const FrameContext& context, CommandSink& sink) {
    if (context.playback->state == PlaybackState::kPlaying) return;
    if (asked_version_ == context.snapshot_version && asked_.object == context.selection.object &&
        asked_.particle == context.selection.particle && asked_.truth == context.selection.truth)
      return;
    asked_version_ = context.snapshot_version;
    asked_ = context.selection;
    ProbeCommand probe{context.selection.object, context.selection.particle, reference_, maps_};
    probe.truth = context.selection.truth;
    sink.Post(probe);
  }

  /// Over the whole run on the left, in this frame on the right.
  void DrawTruth(const FrameContext& context, const TruthView& truth, const ProbeView* probe,
                 CommandSink& sink) {
    ImGui::PushFont(context.fonts.small);
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const bool beside = room.x > context.Scaled(620);
    ImGui::BeginChild("why.truth",
                      {beside ? 0.5f * room.x : room.x, beside ? room.y : 0.5f * room.y});
    DrawMissedView(context, truth, sink);
    ImGui::EndChild();
    if (beside) ImGui::SameLine(0, context.Scaled(10));
    ImGui::BeginChild("why.now", ImGui::GetContentRegionAvail());
    if (probe == nullptr) {
      DimText(context.playback->state == PlaybackState::kPlaying
                  ? "Pause, and its scores in the frame that shows are told here."
                  : "Scoring this frame ..");
    } else if (!probe->message.empty()) {
      DimText("%s", probe->message.c_str());
    } else {
      DrawVerdict(*probe);
      const ImVec2 rest = ImGui::GetContentRegionAvail();
      const float rows = 2.0f + static_cast<float>(probe->hypotheses.size());
      const bool curves = rest.y > context.Scaled(200);  // lower, they tell nothing
      ImGui::BeginChild(
          "why.table",
          {rest.x, curves ? std::min(0.5f * rest.y, rows * ImGui::GetFrameHeight()) : rest.y});
      DrawTable(context, *probe, sink);
      ImGui::EndChild();
      if (curves && maps_) DrawLikelihoodMaps(context, *probe, term_);
      if (curves && !maps_) DrawSlices(context, *probe);
    }
    ImGui::EndChild();
    ImGui::PopFont();
  }

  static void DrawVerdict(const ProbeView& probe) {
    if (!probe.verdict) return;
    ImGui::PushStyleColor(ImGuiCol_Text, *probe.verdict == Verdict::kRight     ? colors::kGood
                                         : *probe.verdict == Verdict::kNoTruth ? colors::kDimText
                                                                               : colors::kWarning);
    ImGui::TextWrapped("%s", probe.verdict_text.c_str());
    ImGui::PopStyleColor();
  }

  static void DrawTable(const FrameContext& context, const ProbeView& probe, CommandSink& sink) {
    const bool rendered = probe.hypotheses.front().phi_edge_rendered.has_value();
    std::vector<TableHead> columns = {
        {"Hypothesis", "Click one: its contour is drawn in the images (switch Contour)."},
        {"Model", "Its shape."},
        {"Off", "Distance of its centre from the true one, and its turn against it."},
        {"\u03a6 det", "Detector term."},
        {"\u03a6 edge", "Edge term, by the scorer that the mapper uses."}};
    if (rendered) columns.push_back({"\u03a6 ref", "Edge term, by the reference scorer."});
    columns.push_back({"Score", "alpha * detector term + beta * edge term."});
    columns.push_back({"Shows",
                       "Share of its contour that is inside the image, and neither hidden nor "
                       "before something known that is as dark."});
    const auto count = static_cast<int>(columns.size());
    if (!ImGui::BeginTable(
            "why.hypotheses", count,
            ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_ScrollY))
      return;
    DrawTableHeads(context, columns);
    float best = probe.hypotheses.front().score;
    for (const ProbedHypothesis& h : probe.hypotheses) best = std::max(best, h.score);
    for (std::size_t i = 0; i < probe.hypotheses.size(); ++i)
      DrawRow(context, probe, i, rendered, best, sink);
    ImGui::EndTable();
  }

  static void DrawRow(const FrameContext& context, const ProbeView& probe, std::size_t index,
                      bool rendered, float best, CommandSink& sink) {
    const ProbedHypothesis& h = probe.hypotheses[index];
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    const std::string name = fmt::format("why.row.{}", index);
    const bool selected = context.selection.hypothesis == static_cast<int>(index);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    if (ImGui::Selectable(("##" + name).c_str(), selected, ImGuiSelectableFlags_SpanAllColumns))
      sink.Post(SelectHypothesisCommand{static_cast<int>(index)});
    LogItem(context, name);
    ImGui::SetCursorScreenPos(corner);
    if (h.is_truth || probe.object.value <= 0)
      Chip(context, colors::kTruth);
    else
      Chip(context, probe.object);
    ImGui::TextUnformatted(h.name.c_str());
    const ModelView* model = context.Model(h.label);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(model != nullptr ? model->name.c_str() : "?");
    ImGui::TableNextColumn();
    if (h.from_truth_m && !h.is_truth)
      ImGui::TextUnformatted(
          model != nullptr && model->any_azimuth
              ? fmt::format("{:.0f} cm", 100 * *h.from_truth_m).c_str()
              : fmt::format("{:.0f} cm, {}", 100 * *h.from_truth_m, AngleText(*h.from_truth_rad))
                    .c_str());
    ImGui::TableNextColumn();
    ImGui::Text("%.2f", h.phi_cnn);
    ImGui::TableNextColumn();
    ImGui::Text("%.2f", h.phi_edge);
    if (rendered) {
      ImGui::TableNextColumn();
      ImGui::Text("%.2f", h.phi_edge_rendered.value_or(0));
    }
    ImGui::TableNextColumn();
    ImGui::PushStyleColor(ImGuiCol_Text, h.score >= best ? colors::kGood : colors::kText);
    ImGui::Text("%.2f", h.score);
    ImGui::PopStyleColor();
    ImGui::TableNextColumn();
    ImGui::Text("%.0f %%", 100 * h.visible_fraction);
  }

  /// Two by two: the score along each parameter.
  static void DrawSlices(const FrameContext& context, const ProbeView& probe) {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    if (room.x < 60 || room.y < 40) return;
    float low = 0, high = 0.5f;
    for (const LikelihoodSlice& slice : probe.slices) {
      for (const float score : slice.score) {
        low = std::min(low, score);
        high = std::max(high, score);
      }
    }
    const float gap = context.Scaled(8);
    const ImVec2 size(0.5f * (room.x - gap), 0.5f * (room.y - gap));
    for (std::size_t i = 0; i < probe.slices.size(); ++i) {
      const ImVec2 at(corner.x + static_cast<float>(i % 2) * (size.x + gap),
                      corner.y + static_cast<float>(i / 2) * (size.y + gap));
      DrawSlice(context, probe, probe.slices[i], at, size, low, high);
    }
  }

  static void DrawSlice(const FrameContext& context, const ProbeView& probe,
                        const LikelihoodSlice& slice, ImVec2 low, ImVec2 size, float min,
                        float max) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float font = context.fonts.small->FontSize;
    const ImVec2 high(low.x + size.x, low.y + size.y - font);
    draw.AddRectFilled(low, high, colors::kInset, context.Scaled(2));
    ImGui::SetCursorScreenPos(low);
    ImGui::InvisibleButton(("why.slice." + slice.parameter).c_str(), size);
    LogItem(context, "why.slice." + slice.parameter);
    const float first = slice.offsets.front(), last = slice.offsets.back();
    const auto x_of = [&](float offset) {
      return low.x + (offset - first) / (last - first) * (high.x - low.x);
    };
    const auto y_of = [&](double value) {
      return high.y - (static_cast<float>(value) - min) / (max - min) * (high.y - low.y);
    };
    const ImU32 middle =
        OnPanel(probe.truth.empty() ? context.ColorOf(probe.object) : colors::kTruth);
    draw.AddLine({x_of(0), low.y}, {x_of(0), high.y}, WithAlpha(middle, 0.7));
    if (slice.truth && *slice.truth >= first && *slice.truth <= last)
      draw.AddLine({x_of(*slice.truth), low.y}, {x_of(*slice.truth), high.y},
                   OnPanel(colors::kTruth), context.Scaled(1.5));
    std::vector<ImVec2> points;
    const auto curve = [&](const std::vector<float>& values, double factor, ImU32 color,
                           float width) {
      points.clear();
      for (std::size_t i = 0; i < values.size(); ++i)
        points.emplace_back(x_of(slice.offsets[i]), y_of(factor * values[i]));
      draw.AddPolyline(points.data(), static_cast<int>(points.size()), color, 0,
                       context.Scaled(width));
    };
    draw.PushClipRect(low, high, true);
    curve(slice.phi_cnn, probe.alpha, WithAlpha(colors::kWarning, 0.8), 1);
    curve(slice.phi_edge, probe.beta, WithAlpha(colors::kAccent, 0.9), 1);
    curve(slice.phi_edge_rendered, probe.beta, IM_COL32(200, 120, 220, 220), 1);
    curve(slice.score, 1, colors::kText, 2);
    draw.PopClipRect();
    const auto text = [&](float x, float y, ImU32 color, const std::string& words, float align) {
      const float width = context.fonts.small->CalcTextSizeA(font, 1e6f, 0, words.c_str()).x;
      draw.AddText(context.fonts.small, font, {x - align * width, y}, color, words.c_str());
    };
    text(low.x + 3, low.y, colors::kDimText, slice.parameter, 0);
    text(low.x, high.y, colors::kFaint, fmt::format("{:.0f} {}", first, slice.unit), 0);
    text(x_of(0), high.y, colors::kFaint, "0", 0.5f);
    text(high.x, high.y, colors::kFaint, fmt::format("+{:.0f}", last), 1);
    if (!ImGui::IsItemHovered()) return;
    const float share = (ImGui::GetIO().MousePos.x - low.x) / (high.x - low.x);
    const auto i = static_cast<std::size_t>(
        std::lround(std::clamp(share, 0.0f, 1.0f) * static_cast<float>(slice.offsets.size() - 1)));
    PutTooltipBeside(context, ImGui::GetItemRectMin(), ImGui::GetItemRectMax());
    ImGui::BeginTooltip();
    ImGui::Text("%+.0f %s %s: score %.2f", slice.offsets[i], slice.unit.c_str(),
                slice.parameter.c_str(), slice.score[i]);
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(colors::kWarning), "detector %.2f",
                       slice.phi_cnn[i]);
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(colors::kAccent), "edges %.2f",
                       slice.phi_edge[i]);
    DimText("White: the whole score. Coloured line: the mean. Green: the truth.");
    ImGui::EndTooltip();
  }

  bool reference_ = false, maps_ = false;
  int term_ = 0;  ///< Of the maps: whole score, edges, detector.
  std::uint64_t asked_version_ = 0;
  Selection asked_;
};

}  // namespace

std::unique_ptr<Panel> MakeWhyPanel() { return std::make_unique<WhyPanel>(); }

}  // namespace plumbline
