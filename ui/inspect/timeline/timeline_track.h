// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <imgui.h>

#include "ui/framework/frame_context.h"

namespace plumbline {

/// The part of time that the track shows, and where on the screen.
struct TimeAxis {
  float x0 = 0, x1 = 1;        ///< Screen
  double first = 0, last = 1;  ///< Frames at x0 and x1.
  float XOf(double frame) const {
    return x0 + static_cast<float>((frame - first) / (last - first)) * (x1 - x0);
  }
  double FrameAt(float x) const { return first + (last - first) * (x - x0) / (x1 - x0); }
};

/// What is drawn under one another, from the top: each kind only if there is room for it.
struct TimelineRows {
  float ruler = 0, thumbnails = 0, bar = 0, lanes = 0, plot = 0, end = 0;  ///< Where each begins.
};

inline constexpr float kLaneHeight = 18;  ///< At text scale 1.

/// @param lanes  How many there are; those that do not fit scroll.
TimelineRows PlanRows(const FrameContext& context, float top, float bottom, std::size_t lanes);
void DrawRuler(const FrameContext& context, const TimeAxis& axis, float y0, float y1);
void DrawThumbnails(const FrameContext& context, const TimeAxis& axis, float y0, float y1);
/// What is mapped, what is played, the sub-range, where a seek goes.
void DrawPlayed(const FrameContext& context, const TimeAxis& axis, float y0, float y1);
/// Where options were changed while the run went on.
void DrawOptionMarks(const FrameContext& context, const TimeAxis& axis, const TimelineRows& rows);

/// Small text over the track.
void TrackText(const FrameContext& context, ImVec2 at, ImU32 color, const std::string& text);
/// "1:02.33" of seconds.
std::string TimeName(double seconds);

}  // namespace plumbline
