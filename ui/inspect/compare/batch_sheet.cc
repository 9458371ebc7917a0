// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/compare/batch_sheet.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/snapshot/commands.h"
#include "ui/framework/actions.h"
#include "ui/framework/path_dialog.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/compare/batch_plot.h"

namespace plumbline {
namespace {

constexpr double kBatchSheetWidth = 980, kPlotHeight = 260, kWorstHeight = 250;

std::string TitleOfRun(const BatchTable& table, const BatchRun& run) {
  std::string title = run.sequence + ", " + run.recipe;
  for (std::size_t i = 0; i < run.point.size() && i < table.options.size(); ++i)
    title += fmt::format(", {} = {:g}", table.options[i], run.point[i]);
  return title + fmt::format(", seed {}", run.seed);
}

std::string FigureOfRun(const BatchTable& table, const BatchRun& run, const char* name) {
  for (std::size_t i = 0; i < table.figures.size() && i < run.figures.size(); ++i) {
    if (table.figures[i].name == name && run.figures[i])
      return fmt::format("{:.3g} {}", *run.figures[i], table.figures[i].unit);
  }
  return "-";
}

std::string MissesInWords(const BatchRun& run) {
  if (run.status != "ok") return run.reason;
  std::string words;
  for (const BatchMiss& miss : run.missed)
    words += (words.empty() ? "" : "\n") + miss.truth + ": " +
             (miss.text.empty() ? miss.cause : miss.text);
  return words.empty() ? "It missed nothing." : words;
}

}  // namespace

void BatchSheet::Draw(const FrameContext& context, const ShownBatch* batch, CommandSink& sink) {
  if (!open_) return;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(context.Scaled(kBatchSheetWidth), 0.94f * display.x), 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, context.Scaled(10));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(24), context.Scaled(18)});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, colors::kSheet);
  ImGui::Begin(
      "batch", nullptr,
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  if (ImGui::IsWindowAppearing()) ImGui::SetWindowFocus();
  if (batch == nullptr) {
    DimText("Reading the batch ..");
  } else if (!batch->problem.empty()) {
    WrappedText(colors::kBad, batch->problem);
    LogItem(context, "batch.problem");
  } else {
    DrawBatch(context, *batch, sink);
  }
  ImGui::Dummy({0, context.Scaled(6)});
  if (Button(context, "batch.close", "Close", "Esc closes it too.") ||
      (ImGui::IsKeyPressed(keys::kEscape, false) && !AsksForPath(context)))
    open_ = false;
  const ImVec2 low = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  context.widgets->Add("batch.sheet", low, {low.x + size.x, low.y + size.y});
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
}

void BatchSheet::DrawBatch(const FrameContext& context, const ShownBatch& batch,
                           CommandSink& sink) {
  const BatchTable& table = batch.view.table;
  ImGui::PushFont(context.fonts.strong);
  ImGui::TextUnformatted(("Batch " + table.name).c_str());
  ImGui::PopFont();
  const auto failed = std::count_if(table.runs.begin(), table.runs.end(),
                                    [](const BatchRun& run) { return run.status != "ok"; });
  const bool one = table.sequences.size() == 1;
  WrappedText(
      colors::kDimText,
      fmt::format("{} runs, {} failed; {} sequence{}, {} recipe{}. Means, and 95 % intervals {}",
                  table.runs.size(), failed, table.sequences.size(), one ? "" : "s",
                  table.recipes.size(), table.recipes.size() == 1 ? "" : "s",
                  one ? "over the seeds of its one sequence." : "for sequences like these."));
  ImGui::Dummy({0, context.Scaled(4)});
  DrawFigureChoice(context, table);
  const IntervalPlot plot = PlotOf(batch.view, figure_);
  DrawIntervalPlot(context, "batch.plot", plot,
                   {ImGui::GetContentRegionAvail().x, context.Scaled(kPlotHeight)});
  for (std::size_t i = 0; i < plot.series.size() && plot.series.size() > 1; ++i) {
    if (i > 0) ImGui::SameLine(0, context.Scaled(16));
    const float width = ImGui::CalcTextSize(plot.series[i].name.c_str()).x + context.Scaled(24);
    if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
    Chip(context, OnPanel(SeriesColor(i)));
    SmallText(context, colors::kText, "%s", plot.series[i].name.c_str());
  }
  ImGui::Dummy({0, context.Scaled(6)});
  DrawWorst(context, batch, sink);
}

void BatchSheet::DrawFigureChoice(const FrameContext& context, const BatchTable& table) {
  if (table.figures.empty()) return;
  figure_ = std::clamp(figure_, 0, static_cast<int>(table.figures.size()) - 1);
  const auto name = [&](int i) {
    const BatchFigure& figure = table.figures[static_cast<std::size_t>(i)];
    return figure.name + (figure.unit.empty() ? "" : " [" + figure.unit + "]");
  };
  ImGui::SetNextItemWidth(context.Scaled(190));
  if (ImGui::BeginCombo("##batch.figure", name(figure_).c_str())) {
    for (int i = 0; i < static_cast<int>(table.figures.size()); ++i) {
      if (ImGui::Selectable(name(i).c_str(), i == figure_)) figure_ = i;
      LogItem(context, "batch.figure." + table.figures[static_cast<std::size_t>(i)].name);
      Tooltip(context, table.figures[static_cast<std::size_t>(i)].help);
    }
    ImGui::EndCombo();
  }
  LogItem(context, "batch.figure");
  ImGui::SameLine();
  const BatchFigure& figure = table.figures[static_cast<std::size_t>(figure_)];
  DimText("%s%s", figure.help.c_str(),
          figure.better > 0   ? "; more is better"
          : figure.better < 0 ? "; less is better"
                              : "");
}

void BatchSheet::DrawWorst(const FrameContext& context, const ShownBatch& batch,
                           CommandSink& sink) {
  const BatchTable& table = batch.view.table;
  SmallText(context, colors::kAccent, "Worst runs");
  ImGui::SameLine();
  SmallText(context, colors::kDimText, "a click opens one; the mouse over it tells what it missed");
  constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_ScrollY;
  if (!ImGui::BeginTable("batch.worst", 5, kFlags, {0, context.Scaled(kWorstHeight)})) return;
  ImGui::TableSetupScrollFreeze(0, 1);
  ImGui::TableSetupColumn("run", 0, 5);
  for (const char* column : {"found", "spurious", "off by", "missed"})
    ImGui::TableSetupColumn(column, 0, 1);
  ImGui::TableNextRow();
  for (const char* column : {"run", "found", "spurious", "off by", "missed"}) {
    ImGui::TableNextColumn();
    SmallText(context, colors::kFaint, "%s", column);
  }
  for (std::size_t i = 0; i < batch.view.worst.size(); ++i) {
    const BatchRun& run = table.runs[static_cast<std::size_t>(batch.view.worst[i])];
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    const std::string widget = "batch.worst." + std::to_string(i);
    const bool ok = run.status == "ok";
    ImGui::PushStyleColor(ImGuiCol_Text, ok ? colors::kText : colors::kBad);
    const std::string label = TitleOfRun(table, run) + (ok ? "" : ": " + run.status);
    if (ImGui::Selectable((label + "##" + widget).c_str(), false,
                          ImGuiSelectableFlags_SpanAllColumns) &&
        ok) {
      sink.Post(OpenCommand{batch.folder + "/" + run.folder + "/run.plb"});
      open_ = false;
    }
    ImGui::PopStyleColor();
    LogItem(context, widget);
    Tooltip(context, MissesInWords(run));
    for (const char* name : {"found", "spurious", "translation"}) {
      ImGui::TableNextColumn();
      DimText("%s", FigureOfRun(table, run, name).c_str());
    }
    ImGui::TableNextColumn();
    DimText("%zu", run.missed.size());
  }
  ImGui::EndTable();
}

}  // namespace plumbline
