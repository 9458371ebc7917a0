// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/snapshot/batch_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Dots with intervals over things side by side, joined by lines where those are values.
struct IntervalPlot {
  struct Series {
    std::string name;
    std::vector<std::optional<MeanEstimate>> at;  ///< As `places`.
  };
  std::string unit;
  std::vector<std::string> places;  ///< Below the axis.
  std::string across;               ///< What they are values of; "": they are names.
  std::vector<Series> series;
};

/// A figure of a batch: by recipe, or over the first swept option, a line for each recipe and value
/// of the second.
IntervalPlot PlotOf(const BatchView& view, int figure);

/// Draws it as an item of this size. Values are told where the mouse is.
void DrawIntervalPlot(const FrameContext& context, const std::string& name,
                      const IntervalPlot& plot, ImVec2 size);

}  // namespace plumbline
