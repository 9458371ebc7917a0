// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

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
struct TrackRows {
  float ruler = 0, thumbnails = 0, bar = 0, lanes = 0, plot = 0, end = 0;  ///< Where each begins.
};

/// The life of one object.
struct ObjectLane {
  ObjectId id;  ///< Not valid: all objects that were never confirmed, together.
  int born = 0;
  int confirmed = -1;  ///< -1: never
  int ended = -1;      ///< -1: lives
  std::vector<const FrameEvent*> events;
};
/// Objects that were confirmed at some time, by birth; then `also`, then one lane for the others.
std::vector<ObjectLane> LanesOf(const std::vector<FrameEvent>& events, ObjectId also);

TrackRows PlanRows(const FrameContext& context, float top, float bottom, std::size_t lanes);
void DrawRuler(const FrameContext& context, const TimeAxis& axis, float y0, float y1);
void DrawThumbnails(const FrameContext& context, const TimeAxis& axis, float y0, float y1);
/// What is mapped, what is played, the sub-range, where a seek goes.
void DrawPlayed(const FrameContext& context, const TimeAxis& axis, float y0, float y1);
void DrawLanes(const FrameContext& context, const TimeAxis& axis, float label_x, float y0, float y1,
               const std::vector<ObjectLane>& lanes);

/// "1:02.33" of seconds.
std::string TimeName(double seconds);

}  // namespace plumbline
