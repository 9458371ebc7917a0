// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/reliability_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr const char* kNothing = "\u2013";

std::string Share(double part, int whole) {
  return whole > 0 ? fmt::format("{:.0f} %", 100.0 * part / whole) : kNothing;
}

std::string NeesText(const Reliability& of) {
  return of.objects > 0 ? fmt::format("{:.1f}", of.nees) : kNothing;
}

struct Judgement {
  ImU32 color;
  std::string words;
  const char* name;  ///< Of the item that says it.
};

const RunReliability::OfObject* WorstOf(const RunReliability& run) {
  const auto worst =
      std::max_element(run.objects.begin(), run.objects.end(),
                       [](const RunReliability::OfObject& a, const RunReliability::OfObject& b) {
                         return a.reliability.nees < b.reliability.nees;
                       });
  return worst == run.objects.end() ? nullptr : &*worst;
}

/// Regions count frames, so they say little about an object that was judged in few of them: NEES,
/// which counts objects, tells of it.
Judgement Judged(const RunReliability& run) {
  const Reliability& all = run.all;
  const double most = static_cast<double>(all.within_95) / all.poses;
  const double half = static_cast<double>(all.within_50) / all.poses;
  if (most < 0.8)
    return {colors::kWarning, "Overconfident: errors exceed the stated uncertainty.",
            "posterior.overconfident"};
  const bool cautious = half > 0.8;
  const RunReliability::OfObject* worst = WorstOf(run);
  if (worst != nullptr && all.nees > all.nees_high) {
    return {colors::kWarning,
            fmt::format("Errors are {} stated, but #{}'s is far larger.",
                        cautious ? "smaller than" : "as large as", worst->object.value),
            "posterior.one_overconfident"};
  }
  if (cautious)
    return {colors::kAccent, "Underconfident: errors are smaller than stated.",
            "posterior.underconfident"};
  return {colors::kGood, "Well calibrated: errors are as large as stated.", "posterior.calibrated"};
}

/// Says so where there is nothing to judge.
bool NothingToJudge(const FrameContext& context, const ObjectHistory& history) {
  if (history.reliability.all.poses > 0) return false;
  WrappedText(colors::kFaint, context.sequence->truth.empty()
                                  ? "Needs ground truth beside the sequence."
                                  : "No confirmed object is near a true one yet.");
  return true;
}

constexpr const char* kCoverageHelp =
    "Over the frames of this run so far in which a confirmed object was updated and a true one of "
    "its category is within 50 cm. Regions are highest-density regions of the believed modes, "
    "widened by how well the truth is known. Frames of one object resemble one another: these are "
    "few independent trials.";

constexpr const char* kNeesHelp =
    "Normalised estimation error squared: 4 on average if the stated covariance is honest, more if "
    "it is too small. The worst objects come first; yellow: beyond what 97.5 % of honest ones "
    "have.";

void Cell(ImU32 color, const std::string& text) {
  ImGui::TableNextColumn();
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopStyleColor();
}

const Reliability* OfObject(const ObjectHistory& history, ObjectId object) {
  for (const RunReliability::OfObject& of : history.reliability.objects) {
    if (of.object == object) return &of.reliability;
  }
  return nullptr;
}

/// A row of the table; of no object: of all together.
void Row(const FrameContext& context, ObjectId object, const Reliability& of) {
  ImGui::TableNextRow();
  if (object.value > 0) {
    ImGui::TableNextColumn();
    Chip(context, object);
    ImGui::Text("#%d", object.value);
  } else {
    Cell(colors::kText, "all");
  }
  Cell(colors::kText, Share(of.within_50, of.poses));
  Cell(colors::kText, Share(of.within_95, of.poses));
  const bool beyond = of.objects > 0 && of.nees > of.nees_high;
  Cell(beyond ? colors::kWarning : colors::kText, NeesText(of));
  Cell(colors::kFaint, fmt::format("{}", of.poses));
}

void DrawJudgement(const FrameContext& context, const RunReliability& run) {
  const Judgement judgement = Judged(run);
  WrappedText(judgement.color, judgement.words);
  LogItem(context, judgement.name);
}

/// All objects together, then each, the worst first.
void DrawTable(const FrameContext& context, const ObjectHistory& history) {
  const RunReliability& run = history.reliability;
  DrawJudgement(context, run);
  Tooltip(context, kCoverageHelp);
  constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_ScrollY;
  if (!ImGui::BeginTable("posterior.coverage", 5, kFlags)) return;
  ImGui::TableSetupScrollFreeze(0, 2);
  ImGui::TableNextRow();
  for (const char* title : {"truth in", "50 %", "95 %", "NEES", "frames"}) {
    Cell(colors::kFaint, title);
    Tooltip(context, title == std::string_view("NEES") ? kNeesHelp : kCoverageHelp);
  }
  Row(context, {}, run.all);
  std::vector<RunReliability::OfObject> objects = run.objects;
  std::stable_sort(objects.begin(), objects.end(),
                   [](const RunReliability::OfObject& a, const RunReliability::OfObject& b) {
                     return a.reliability.nees > b.reliability.nees;
                   });
  for (const RunReliability::OfObject& of : objects) {
    Row(context, of.object, of.reliability);
    if (of.object == history.object)
      ImGui::TableSetBgColor(ImGuiTableBgTarget_RowBg0, colors::kControl);
  }
  ImGui::EndTable();
}

/// A square from (0, 0) to (1, 1) with a caption above and the names of its axes.
struct UnitPlot {
  ImVec2 low, high;
  ImVec2 At(double x, double y) const {
    return {low.x + static_cast<float>(x) * (high.x - low.x),
            high.y - static_cast<float>(y) * (high.y - low.y)};
  }
};

void PlotText(const FrameContext& context, ImVec2 at, float align, ImU32 color,
              const std::string& words) {
  ImFont* font = context.fonts.small;
  const float width = font->CalcTextSizeA(font->FontSize, 1e6f, 0, words.c_str()).x;
  ImGui::GetWindowDrawList()->AddText(font, font->FontSize, {at.x - align * width, at.y}, color,
                                      words.c_str());
}

UnitPlot BeginPlot(const FrameContext& context, const char* name, ImVec2 corner, ImVec2 size,
                   const char* title, const std::string& figure, const char* across,
                   const std::string& help) {
  const float font = context.fonts.small->FontSize;
  const UnitPlot plot{{corner.x, corner.y + font + 2},
                      {corner.x + size.x, corner.y + size.y - font - 1}};
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddRectFilled(plot.low, plot.high, colors::kInset, context.Scaled(2));
  draw.AddLine(plot.At(0.5, 0), plot.At(0.5, 1), colors::kBorder);
  draw.AddLine(plot.At(0, 0.5), plot.At(1, 0.5), colors::kBorder);
  PlotText(context, corner, 0, colors::kDimText, title);
  PlotText(context, {plot.high.x, corner.y}, 1, colors::kText, figure);
  PlotText(context, {plot.low.x, plot.high.y + 1}, 0, colors::kFaint, "0");
  PlotText(context, {0.5f * (plot.low.x + plot.high.x), plot.high.y + 1}, 0.5f, colors::kFaint,
           across);
  PlotText(context, {plot.high.x, plot.high.y + 1}, 1, colors::kFaint, "1");
  ImGui::SetCursorScreenPos(corner);
  ImGui::InvisibleButton(name, size);
  LogItem(context, name);
  Tooltip(context, help);
  return plot;
}

void DrawLabels(const FrameContext& context, const LabelCalibration& labels, ImVec2 corner,
                ImVec2 size) {
  const auto error = labels.ExpectedError();
  std::string help =
      "Shapes: how often the most likely one was right, against how surely it was believed. On the "
      "line: honest; below it: too sure. The figure is the expected calibration error. Only "
      "categories with several models count.";
  for (std::size_t i = 0; i < labels.bins.size(); ++i) {
    const LabelCalibration::Bin& bin = labels.bins[i];
    if (bin.count > 0)
      help += fmt::format("\nbelieved at {:.0f} %: right in {:.0f} % of {}",
                          100 * bin.claimed / bin.count, 100.0 * bin.right / bin.count, bin.count);
  }
  const UnitPlot plot =
      BeginPlot(context, "posterior.labels_diagram", corner, size, "shapes right",
                error ? fmt::format("ECE {:.1f} %", 100 * *error) : "", "believed", help);
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float half = 0.42f * (plot.high.x - plot.low.x) / static_cast<float>(labels.bins.size());
  for (const LabelCalibration::Bin& bin : labels.bins) {
    if (bin.count == 0) continue;
    const double right = static_cast<double>(bin.right) / bin.count;
    const double claimed = bin.claimed / bin.count;
    const ImVec2 top = plot.At(claimed, std::max(right, 0.02));
    const float left = std::max(plot.low.x, top.x - half);
    const float end = std::min(plot.high.x, top.x + half);
    const bool too_sure = right < claimed - 0.05;
    draw.AddRectFilled({left, top.y}, {end, plot.high.y},
                       WithAlpha(too_sure ? colors::kWarning : colors::kAccent, 0.7));
  }
  draw.AddLine(plot.At(0, 0), plot.At(1, 1), colors::kFaint, context.Scaled(1));
  if (labels.count == 0)
    PlotText(context, plot.At(0.5, 0.55), 0.5f, colors::kFaint, "no choice of shapes");
}

void DrawConfirmation(const FrameContext& context, const PrecisionRecall& curve, ImVec2 corner,
                      ImVec2 size) {
  const UnitPlot plot = BeginPlot(
      context, "posterior.precision_recall", corner, size, "precision",
      fmt::format("AP {:.2f}", curve.average_precision), "recall",
      fmt::format("Objects of the newest frame, confirmed or not, by falling probability of being "
                  "there: the share of them that is (upwards) against the share that they are of "
                  "the {} true objects (across), seen so far or not. AP: the area under the steps.",
                  curve.truths));
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  double recall = 0;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const PrecisionRecallPoint& point = curve.points[i];
    draw.AddRectFilled(plot.At(recall, point.precision), plot.At(point.recall, 0),
                       WithAlpha(colors::kAccent, 0.25));
    draw.AddLine(plot.At(recall, point.precision), plot.At(point.recall, point.precision),
                 colors::kAccent, context.Scaled(1.5));
    const double next = i + 1 < curve.points.size() ? curve.points[i + 1].precision : 0;
    draw.AddLine(plot.At(point.recall, point.precision), plot.At(point.recall, next),
                 colors::kAccent, context.Scaled(1.5));
    recall = point.recall;
  }
}

}  // namespace

void DrawReliabilitySummary(const FrameContext& context, const ObjectHistory& history) {
  DimText("Is the uncertainty reliable?");
  Tooltip(context, kCoverageHelp);
  if (NothingToJudge(context, history)) return;
  const Reliability& all = history.reliability.all;
  DrawJudgement(context, history.reliability);
  if (!ImGui::BeginTable("posterior.table", 3, ImGuiTableFlags_SizingStretchProp)) return;
  const Reliability* object = OfObject(history, history.object);
  const Reliability none;
  if (object == nullptr) object = &none;
  const auto row = [&](const char* name, const std::string& of_object, const std::string& of_all) {
    ImGui::TableNextRow();
    Cell(colors::kDimText, name);
    Cell(colors::kText, of_object);
    Cell(colors::kText, of_all);
  };
  ImGui::TableNextRow();
  Cell(colors::kFaint, "truth in the");
  Cell(colors::kFaint, fmt::format("#{}", history.object.value));
  Cell(colors::kFaint, "all");
  row("50 % region", Share(object->within_50, object->poses), Share(all.within_50, all.poses));
  row("95 % region", Share(object->within_95, object->poses), Share(all.within_95, all.poses));
  row("NEES", NeesText(*object), NeesText(all));
  Tooltip(context, kNeesHelp);
  ImGui::EndTable();
}

void DrawReliability(const FrameContext& context, const ObjectHistory& history, ImVec2 corner,
                     ImVec2 size) {
  const float gap = context.Scaled(20);
  const float square = std::min(size.y, 0.25f * size.x);
  const bool beside = square > context.Scaled(80);
  const float width = beside ? size.x - 2 * (1.4f * square + gap) : size.x;
  ImGui::SetCursorScreenPos(corner);
  ImGui::BeginChild("posterior.figures", {width, size.y});
  if (!NothingToJudge(context, history)) DrawTable(context, history);
  ImGui::EndChild();
  LogItem(context, "posterior.reliability_table");
  if (!beside) return;
  const ImVec2 plot(1.4f * square, size.y);
  DrawLabels(context, history.reliability.all.labels, {corner.x + width + gap, corner.y}, plot);
  DrawConfirmation(context, history.confirmation, {corner.x + width + 2 * gap + plot.x, corner.y},
                   plot);
}

}  // namespace plumbline
