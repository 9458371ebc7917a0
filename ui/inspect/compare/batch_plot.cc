// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/compare/batch_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr int kTicks = 4;
constexpr double kMostOverMeans = 3;

/// 1, 2 or 5 times a power of ten, at least `value`.
double RoundAbove(double value) {
  if (!(value > 0)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * power * (1 + 1e-9)) return step * power;
  }
  return 10 * power;
}

double MostOf(const IntervalPlot& plot) {
  if (plot.unit == "%") return 100;
  double most = 0, mean = 0;
  for (const IntervalPlot::Series& series : plot.series) {
    for (const auto& at : series.at) {
      if (!at) continue;
      mean = std::max(mean, at->mean);
      most = std::max(most, at->high.value_or(at->mean));
    }
  }
  most = std::min(most, kMostOverMeans * mean);  // one wide interval would hide the others
  return RoundAbove(most);
}

std::string InWordsOf(const std::string& unit, const MeanEstimate& at) {
  const std::string interval =
      at.low ? fmt::format(" [{:.2f}, {:.2f}]", *at.low, *at.high) : std::string();
  return fmt::format("{:.2f}{}{}{}", at.mean, interval, unit.empty() ? "" : " ", unit);
}

/// Where values lie on the screen.
struct BatchAxes {
  ImVec2 low, high;
  std::size_t places = 1;
  double most = 1;

  float X(double place) const {
    return low.x +
           (high.x - low.x) * static_cast<float>((place + 0.5) / static_cast<double>(places));
  }
  float Y(double value) const {
    return high.y - (high.y - low.y) * static_cast<float>(std::clamp(value / most, 0.0, 1.0));
  }
};

void SmallTextAt(const FrameContext& context, ImVec2 at, float align, const std::string& words,
                 float room) {
  ImFont* font = context.fonts.small;
  std::string text = words;
  const auto width = [&] { return font->CalcTextSizeA(font->FontSize, 1e6f, 0, text.c_str()).x; };
  while (text.size() > 4 && width() > room) text = text.substr(0, text.size() - 3) + "..";
  ImGui::GetWindowDrawList()->AddText(font, font->FontSize, {at.x - align * width(), at.y},
                                      colors::kDimText, text.c_str());
}

void DrawAxes(const FrameContext& context, const IntervalPlot& plot, const BatchAxes& axes) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddRectFilled(axes.low, axes.high, colors::kInset, context.Scaled(3));
  const float font = context.fonts.small->FontSize;
  for (int i = 0; i <= kTicks; ++i) {
    const double value = axes.most * i / kTicks;
    const float y = axes.Y(value);
    draw.AddLine({axes.low.x, y}, {axes.high.x, y}, colors::kBorder);
    SmallTextAt(context, {axes.low.x - context.Scaled(6), y - 0.5f * font}, 1,
                fmt::format("{:g}", value), 1e6f);
  }
  const float room = (axes.high.x - axes.low.x) / static_cast<float>(axes.places);
  for (std::size_t i = 0; i < plot.places.size(); ++i)
    SmallTextAt(context, {axes.X(static_cast<double>(i)), axes.high.y + context.Scaled(3)}, 0.5f,
                plot.places[i], room - context.Scaled(6));
  if (!plot.across.empty())
    SmallTextAt(context, {axes.high.x, axes.high.y + font + context.Scaled(4)}, 1, plot.across,
                1e6f);
}

void DrawSeries(const FrameContext& context, const IntervalPlot& plot, const BatchAxes& axes,
                std::size_t number) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const IntervalPlot::Series& series = plot.series[number];
  const ImU32 color = OnPanel(SeriesColor(number));
  // Side by side, so that intervals do not hide one another.
  const double shift =
      0.06 * (static_cast<double>(number) - 0.5 * static_cast<double>(plot.series.size() - 1));
  std::optional<ImVec2> before;
  for (std::size_t i = 0; i < series.at.size(); ++i) {
    const auto& at = series.at[i];
    if (!at) {
      before.reset();
      continue;
    }
    const ImVec2 dot{axes.X(static_cast<double>(i) + shift), axes.Y(at->mean)};
    if (before && !plot.across.empty()) draw.AddLine(*before, dot, color, context.Scaled(2));
    before = dot;
    if (at->low) {
      const float low = axes.Y(*at->low), high = axes.Y(*at->high), end = context.Scaled(4);
      draw.AddLine({dot.x, low}, {dot.x, high}, WithAlpha(color, 0.7), context.Scaled(1.5));
      for (const float y : {low, high})
        draw.AddLine({dot.x - end, y}, {dot.x + end, y}, WithAlpha(color, 0.7),
                     context.Scaled(1.5));
    }
    draw.AddCircleFilled(dot, context.Scaled(4.5), color);
  }
}

}  // namespace

IntervalPlot PlotOf(const BatchView& view, int figure) {
  IntervalPlot plot;
  const BatchTable& table = view.table;
  if (figure < 0 || figure >= static_cast<int>(table.figures.size())) return plot;
  plot.unit = table.figures[static_cast<std::size_t>(figure)].unit;
  if (table.options.empty()) {
    plot.places = table.recipes;
    plot.series.push_back({"", std::vector<std::optional<MeanEstimate>>(table.recipes.size())});
    for (const BatchEstimate& estimate : view.means) {
      if (estimate.figure == figure)
        plot.series[0].at[static_cast<std::size_t>(estimate.recipe)] = estimate.mean;
    }
    return plot;
  }
  plot.across = table.options[0];
  std::set<double> values;
  for (const BatchEstimate& estimate : view.responses) values.insert(estimate.point[0]);
  for (const double value : values) plot.places.push_back(fmt::format("{:g}", value));
  std::map<std::string, std::size_t> lines;
  for (const BatchEstimate& estimate : view.responses) {
    if (estimate.figure != figure) continue;
    std::string name = table.recipes[static_cast<std::size_t>(estimate.recipe)];
    if (estimate.point.size() > 1)
      name += fmt::format(", {} = {:g}", table.options[1], estimate.point[1]);
    const auto [line, fresh] = lines.try_emplace(name, plot.series.size());
    if (fresh)
      plot.series.push_back({name, std::vector<std::optional<MeanEstimate>>(values.size())});
    const auto place = std::distance(values.begin(), values.find(estimate.point[0]));
    plot.series[line->second].at[static_cast<std::size_t>(place)] = estimate.mean;
  }
  return plot;
}

void DrawIntervalPlot(const FrameContext& context, const std::string& name,
                      const IntervalPlot& plot, ImVec2 size) {
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float font = context.fonts.small->FontSize;
  const BatchAxes axes{{corner.x + context.Scaled(44), corner.y + context.Scaled(6)},
                       {corner.x + size.x, corner.y + size.y - 2 * font - context.Scaled(8)},
                       std::max<std::size_t>(1, plot.places.size()),
                       MostOf(plot)};
  DrawAxes(context, plot, axes);
  for (std::size_t i = 0; i < plot.series.size(); ++i) DrawSeries(context, plot, axes, i);
  ImGui::InvisibleButton(name.c_str(), size);
  LogItem(context, name);
  if (!ImGui::IsItemHovered()) return;
  const float share = (ImGui::GetIO().MousePos.x - axes.low.x) / (axes.high.x - axes.low.x);
  const auto place = static_cast<std::size_t>(
      std::clamp(static_cast<double>(share) * static_cast<double>(axes.places), 0.0,
                 static_cast<double>(axes.places) - 1));
  if (place >= plot.places.size()) return;
  std::string words = (plot.across.empty() ? "" : plot.across + " = ") + plot.places[place];
  for (const IntervalPlot::Series& series : plot.series) {
    if (series.at[place])
      words += "\n" + (series.name.empty() ? "" : series.name + ": ") +
               InWordsOf(plot.unit, *series.at[place]);
  }
  Tooltip(context, words);
}

}  // namespace plumbline
