// SPDX-License-Identifier: Apache-2.0
#include "app/report/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumbline {
namespace {

constexpr int kLeft = 52, kRight = 12, kTop = 26, kBottom = 34;

struct Axes {
  const SvgPlot& plot;
  double x0 = 0, x1 = 1, y1 = 1;

  double X(double x) const { return kLeft + (x - x0) / (x1 - x0) * (plot.width - kLeft - kRight); }
  double Y(double y) const {
    return plot.height - kBottom - std::clamp(y, 0.0, y1) / y1 * (plot.height - kTop - kBottom);
  }
};

Axes AxesOf(const SvgPlot& plot, const std::vector<SvgSeries>& series, double most) {
  Axes axes{plot};
  axes.x0 = std::numeric_limits<double>::max();
  axes.x1 = -axes.x0;
  for (const SvgSeries& s : series) {
    for (const double x : s.x) {
      axes.x0 = std::min(axes.x0, x);
      axes.x1 = std::max(axes.x1, x);
    }
  }
  if (!plot.x_names.empty()) {  // all of them, also where no series has a value
    axes.x0 = 0;
    axes.x1 = static_cast<double>(plot.x_names.size()) - 1;
  }
  if (axes.x1 <= axes.x0) axes.x1 = axes.x0 + 1;
  axes.y1 = plot.y_most > 0 ? plot.y_most : NiceCeiling(most);
  return axes;
}

std::string Text(double x, double y, const char* anchor, const std::string& kind,
                 const std::string& words) {
  return fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='{}' class='{}'>{}</text>", x, y,
                     anchor, kind, Escaped(words));
}

std::string PlotFrame(const Axes& axes) {
  const SvgPlot& plot = axes.plot;
  std::string svg = fmt::format(
      "<svg viewBox='0 0 {0} {1}' width='{0}' height='{1}' role='img' aria-label='{2}'>",
      plot.width, plot.height, Escaped(plot.title));
  svg += Text(kLeft, 15, "start", "title", plot.title);
  for (int i = 0; i <= 4; ++i) {
    const double value = axes.y1 * i / 4, y = axes.Y(value);
    svg += fmt::format("<line x1='{}' x2='{}' y1='{:.1f}' y2='{:.1f}' class='grid'/>", kLeft,
                       plot.width - kRight, y, y);
    svg += Text(kLeft - 6, y + 4, "end", "tick", fmt::format("{:g}", value));
  }
  const double step = NiceCeiling((axes.x1 - axes.x0) / 10);
  const int below = plot.height - kBottom + 16;
  for (double x = std::ceil(axes.x0 / step) * step; plot.x_names.empty() && x <= axes.x1 + 1e-9;
       x += step)
    svg += Text(axes.X(x), below, "middle", "tick", fmt::format("{:g}", x));
  for (std::size_t i = 0; i < plot.x_names.size(); ++i)
    svg += Text(axes.X(static_cast<double>(i)), below, "middle", "tick", plot.x_names[i]);
  svg += Text(plot.width - kRight, plot.height - 4, "end", "tick", plot.x_label);
  svg += Text(plot.width - kRight, 15, "end", "tick", plot.y_label);
  return svg;
}

/// The area between the ends of a series' intervals, and a dot at each value.
std::string BandOf(const SvgSeries& s, const Axes& axes) {
  if (s.low.empty()) return "";
  std::string above, below, dots;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    if (!std::isfinite(s.low[i]) || !std::isfinite(s.high[i])) continue;
    above += fmt::format("{:.1f},{:.1f} ", axes.X(s.x[i]), axes.Y(s.high[i]));
    below = fmt::format("{:.1f},{:.1f} ", axes.X(s.x[i]), axes.Y(s.low[i])) + below;
  }
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    if (std::isfinite(s.y[i]))
      dots += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>", axes.X(s.x[i]),
                          axes.Y(s.y[i]), s.color);
  }
  return fmt::format("<polygon points='{}{}' fill='{}' fill-opacity='.14'/>{}", above, below,
                     s.color, dots);
}

}  // namespace

double NiceCeiling(double value) {
  if (!(value > 0)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * power * (1 + 1e-9)) return step * power;
  }
  return 10 * power;
}

std::string SvgColor(const LookColor& color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color.red, color.green, color.blue);
}

std::string SvgColor(int number) { return SvgColor(ColorOf({std::max(0, number - 1)})); }

std::string Escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '\'':
        out += "&#39;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string SvgLines(const SvgPlot& plot, const std::vector<SvgSeries>& series) {
  double most = 0;
  for (const SvgSeries& s : series) {
    for (const std::vector<double>& values : {s.y, s.high}) {
      for (const double y : values) {
        if (std::isfinite(y)) most = std::max(most, y);
      }
    }
  }
  const Axes axes = AxesOf(plot, series, most);
  std::string svg = PlotFrame(axes);
  for (const SvgSeries& s : series) {
    std::string points;
    const auto flush = [&] {
      if (!points.empty())
        svg += fmt::format(
            "<polyline points='{}' fill='none' stroke='{}' stroke-width='{}'{}><title>{}</title>"
            "</polyline>",
            points, s.color, s.bold ? 2.5 : 1.5, s.dashed ? " stroke-dasharray='6 4'" : "",
            Escaped(s.name));
      points.clear();
    };
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      if (std::isfinite(s.y[i]))
        points += fmt::format("{:.1f},{:.1f} ", axes.X(s.x[i]), axes.Y(s.y[i]));
      else
        flush();
    }
    flush();
    svg += BandOf(s, axes);
  }
  return svg + "</svg>";
}

std::string SvgStack(const SvgPlot& plot, const std::vector<SvgSeries>& series) {
  if (series.empty()) return "";
  std::vector<double> base(series.front().x.size(), 0.0), total = base;
  for (const SvgSeries& s : series) {
    for (std::size_t i = 0; i < s.y.size(); ++i) total[i] += s.y[i];
  }
  const double most = total.empty() ? 1 : *std::max_element(total.begin(), total.end());
  const Axes axes = AxesOf(plot, series, most);
  std::string svg = PlotFrame(axes);
  for (const SvgSeries& s : series) {
    std::string above, below;
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      above += fmt::format("{:.1f},{:.1f} ", axes.X(s.x[i]), axes.Y(base[i] + s.y[i]));
      below = fmt::format("{:.1f},{:.1f} ", axes.X(s.x[i]), axes.Y(base[i])) + below;
      base[i] += s.y[i];
    }
    svg += fmt::format("<polygon points='{}{}' fill='{}'><title>{}</title></polygon>", above, below,
                       s.color, Escaped(s.name));
  }
  return svg + "</svg>";
}

}  // namespace plumbline
