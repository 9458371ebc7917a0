// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/snapshot/object_look.h"

namespace plumbline {

// Plots as SVG text that stands in a web page by itself.

struct SvgSeries {
  std::string name;
  std::string color;  ///< As CSS takes it.
  bool bold = false;
  bool dashed = false;
  std::vector<double> x, y;       ///< A NaN interrupts the line.
  std::vector<double> low, high;  ///< A band about the line, as long as it; empty: none.
};

struct SvgPlot {
  std::string title, x_label, y_label;
  int width = 860, height = 220;
  double y_most = 0;  ///< The axis ends here instead of at the largest value; 0: there.
  std::vector<std::string> x_names{};  ///< What stands below x = 0, 1, ..; empty: numbers.
};

/// Lines over a common axis; the y axis starts at 0.
std::string SvgLines(const SvgPlot& plot, const std::vector<SvgSeries>& series);

/// Areas, one upon the other. All series have the same x.
std::string SvgStack(const SvgPlot& plot, const std::vector<SvgSeries>& series);

/// Colour of the `number`-th of several things, from 1.
std::string SvgColor(int number);
std::string SvgColor(const LookColor& color);

/// Text in HTML or SVG: & < > and quotes are escaped.
std::string Escaped(const std::string& text);

/// 1, 2 or 5 times a power of ten, at least `value`.
double NiceCeiling(double value);

}  // namespace plumbline
