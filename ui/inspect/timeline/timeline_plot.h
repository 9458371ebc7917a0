// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "ui/inspect/timeline/timeline_track.h"

namespace plumbline {

/// Something that an object has in every frame.
struct PlottedQuantity {
  const char* id;  ///< For settings.
  const char* name;
  const char* unit;
  const char* help;
  std::optional<float> (*value)(const ObjectSample& sample);  ///< In `unit`.
  const char* nothing;  ///< What is said where no object has it.
};
std::span<const PlottedQuantity> PlottedQuantities();

/// Curves of all objects, the selected one bold, from 0 (or below) to the largest value that shows.
void DrawPlot(const FrameContext& context, const TimeAxis& axis, float label_x, float y0, float y1,
              const PlottedQuantity& quantity);

/// "3.1 cm" of the selected object in the frame that is shown; "" if it has none.
std::string ValueNow(const FrameContext& context, const PlottedQuantity& quantity);

}  // namespace plumbline
