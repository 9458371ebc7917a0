// SPDX-License-Identifier: Apache-2.0
#include "app/report/batch_responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "app/report/svg_plot.h"

namespace plumbline {
namespace {

constexpr int kMostLines = 8;
constexpr double kMostOverMeans = 3;

/// One line of a response: a recipe, and a value of the second option where there is one.
struct ResponseLine {
  int recipe = 0;
  std::optional<double> second;
  bool operator<(const ResponseLine& o) const {
    return std::tie(recipe, second) < std::tie(o.recipe, o.second);
  }
};

std::string ResponsePlot(const BatchView& view, int figure, const std::vector<double>& values) {
  const BatchTable& table = view.table;
  std::map<ResponseLine, SvgSeries> lines;
  double most = 0, mean = 0;
  for (const BatchEstimate& estimate : view.responses) {
    if (estimate.figure != figure || !estimate.mean) continue;
    ResponseLine key{estimate.recipe, std::nullopt};
    if (estimate.point.size() > 1) key.second = estimate.point[1];
    SvgSeries& line = lines[key];
    const auto at = std::find(values.begin(), values.end(), estimate.point[0]) - values.begin();
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    line.x.push_back(static_cast<double>(at));
    line.y.push_back(estimate.mean->mean);
    line.low.push_back(estimate.mean->low.value_or(kNone));
    line.high.push_back(estimate.mean->high.value_or(kNone));
    mean = std::max(mean, estimate.mean->mean);
    most = std::max(most, estimate.mean->high.value_or(estimate.mean->mean));
  }
  if (mean <= 0 || lines.size() > static_cast<std::size_t>(kMostLines)) return "";
  std::vector<SvgSeries> series;
  std::string legend;
  for (auto& [key, line] : lines) {
    line.color = SvgColor(static_cast<int>(series.size()) + 1);
    line.bold = true;
    line.name = table.recipes[static_cast<std::size_t>(key.recipe)];
    if (key.second) line.name += fmt::format(", {}={:g}", table.options[1], *key.second);
    legend += fmt::format("<span><span class='dot' style='background:{}'></span>{}</span>",
                          line.color, Escaped(line.name));
    series.push_back(std::move(line));
  }
  const BatchFigure& of = view.table.figures[static_cast<std::size_t>(figure)];
  SvgPlot plot{of.name, table.options[0], of.unit, 500, 220};
  // One wide interval would hide the others.
  plot.y_most = of.unit == "%" ? 100 : NiceCeiling(std::min(most, kMostOverMeans * mean));
  for (const double value : values) plot.x_names.push_back(fmt::format("{:g}", value));
  return "<figure>" + SvgLines(plot, series) +
         (lines.size() > 1 ? "<figcaption class='legend'>" + legend + "</figcaption>" : "") +
         "</figure>";
}

/// Rows: values of the second option; columns: of the first; the better a mean, the greener.
std::string ResponseGrid(const BatchView& view, int figure, int recipe) {
  const BatchTable& table = view.table;
  const BatchFigure& of = table.figures[static_cast<std::size_t>(figure)];
  std::map<double, std::map<double, double>> rows;
  double least = std::numeric_limits<double>::max(), most = -least;
  for (const BatchEstimate& estimate : view.responses) {
    if (estimate.figure != figure || estimate.recipe != recipe || !estimate.mean) continue;
    const double mean = estimate.mean->mean;
    rows[estimate.point[1]][estimate.point[0]] = mean;
    least = std::min(least, mean);
    most = std::max(most, mean);
  }
  if (most <= least) return "";
  std::string html = fmt::format("<table><tr><th>{}{}, {}</th>", Escaped(of.name),
                                 of.unit.empty() ? "" : " [" + Escaped(of.unit) + "]",
                                 Escaped(table.recipes[static_cast<std::size_t>(recipe)]));
  std::set<double> columns;
  for (const auto& [second, row] : rows) {
    for (const auto& [first, mean] : row) columns.insert(first);
  }
  for (const double first : columns) html += fmt::format("<th>{:g}</th>", first);
  html += "</tr>";
  for (const auto& [second, row] : rows) {
    html += fmt::format("<tr><td>{} = {:g}</td>", Escaped(table.options[1]), second);
    for (const double first : columns) {
      const auto found = row.find(first);
      if (found == row.end()) {
        html += "<td>-</td>";
        continue;
      }
      const double share = (found->second - least) / (most - least);
      const double good = of.better < 0 ? 1 - share : share;
      html += fmt::format("<td style='background:rgba(31,125,85,{:.2f})'>{:.2f}</td>",
                          of.better == 0 ? 0 : 0.45 * good, found->second);
    }
    html += "</tr>";
  }
  return html + "</table><br>";
}

std::string ResponseGrids(const BatchView& view) {
  if (view.table.options.size() < 2) return "";
  std::string grids;
  for (int figure = 0; figure < static_cast<int>(view.table.figures.size()); ++figure) {
    for (int recipe = 0; recipe < static_cast<int>(view.table.recipes.size()); ++recipe)
      grids += ResponseGrid(view, figure, recipe);
  }
  return fmt::format(
      "<details open><summary>Means over {} (columns) and {} (rows)</summary>{}"
      "</details>",
      Escaped(view.table.options[0]), Escaped(view.table.options[1]), grids);
}

}  // namespace

std::string BatchResponsesHtml(const BatchView& view) {
  if (view.responses.empty()) return "";
  const BatchTable& table = view.table;
  std::set<double> first;
  for (const BatchEstimate& estimate : view.responses) first.insert(estimate.point[0]);
  const std::vector<double> values(first.begin(), first.end());
  std::string plots;
  for (int figure = 0; figure < static_cast<int>(table.figures.size()); ++figure)
    plots += ResponsePlot(view, figure, values);
  std::string html = "<h2>Responses to " + Escaped(table.options[0]) +
                     (table.options.size() > 1 ? " and " + Escaped(table.options[1]) : "") +
                     "</h2>";
  if (!plots.empty())
    html +=
        "<div class='pictures'>" + plots +
        "</div><p class='legend'>Dots: means; areas: 95 % intervals at each point alone. Values "
        "stand side by side, whatever lies between them.</p>";
  return html + ResponseGrids(view);
}

}  // namespace plumbline
