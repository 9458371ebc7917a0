// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/timeline_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

constexpr float kBarHeight = 10, kRulerHeight = 16, kThumbnailHeight = 38;
constexpr float kLeastPlotHeight = 34, kPlotHeight = 60;

ImDrawList& Draw() { return *ImGui::GetWindowDrawList(); }

float WidthOf(const FrameContext& context, const std::string& text) {
  return context.fonts.small->CalcTextSizeA(context.fonts.small->FontSize, 1e6f, 0, text.c_str()).x;
}

/// Frames between numbers of the ruler: 1, 2, 5, 10 ... so that they stand apart.
int RulerStep(double frames_per_label) {
  for (int decade = 1;; decade *= 10) {
    for (const int step : {1, 2, 5}) {
      if (step * decade >= frames_per_label) return step * decade;
    }
  }
}

}  // namespace

void TrackText(const FrameContext& context, ImVec2 at, ImU32 color, const std::string& text) {
  Draw().AddText(context.fonts.small, context.fonts.small->FontSize, at, color, text.c_str());
}

std::string TimeName(double seconds) {
  const int minutes = static_cast<int>(seconds / 60);
  return fmt::format("{}:{:05.2f}", minutes, seconds - 60 * minutes);
}

TimelineRows PlanRows(const FrameContext& context, float top, float bottom, std::size_t lanes) {
  TimelineRows rows;
  const float room = bottom - top;
  rows.ruler = top;
  float y = top + context.Scaled(kRulerHeight);
  rows.thumbnails = y;
  if (room > context.Scaled(150)) y += context.Scaled(kThumbnailHeight);
  rows.bar = y;
  y += context.Scaled(kBarHeight);
  rows.lanes = y;
  const float left = bottom - y;
  // The plot keeps its place; lanes that do not fit above it scroll, whole ones at a time.
  const float lane = context.Scaled(kLaneHeight), wanted = lane * static_cast<float>(lanes);
  const float least_plot = context.Scaled(kLeastPlotHeight);
  const bool plot = left > least_plot + lane;
  const float room_for_lanes =
      plot ? std::max(left - context.Scaled(kPlotHeight), std::min(0.6f * left, left - least_plot))
           : left;
  y += std::min(wanted, std::max(lane, lane * std::floor(room_for_lanes / lane)));
  rows.plot = plot ? y + context.Scaled(3) : bottom;
  rows.end = bottom;
  return rows;
}

void DrawRuler(const FrameContext& context, const TimeAxis& axis, float y0, float y1) {
  const double rate = context.sequence != nullptr ? context.sequence->rate_hz : 30;
  const double per_pixel = (axis.last - axis.first) / (axis.x1 - axis.x0);
  const int step = RulerStep(per_pixel * context.Scaled(96));
  const int first = std::max(0, static_cast<int>(std::ceil(axis.first / step)) * step);
  for (int frame = first; frame <= axis.last; frame += step) {
    const float x = axis.XOf(frame);
    Draw().AddLine({x, y0 + context.Scaled(3)}, {x, y1}, colors::kBorder);
    const std::string number = std::to_string(frame);
    TrackText(context, {x + context.Scaled(4), y0}, colors::kDimText, number);
    const std::string time = TimeName(frame / rate);
    const float time_x = x + context.Scaled(10) + WidthOf(context, number);
    if (time_x + WidthOf(context, time) < std::min(axis.XOf(frame + step), axis.x1))
      TrackText(context, {time_x, y0}, colors::kFaint, time);
  }
  for (const Bookmark& bookmark : context.bookmarks) {
    const float x = axis.XOf(bookmark.frame);
    if (x < axis.x0 || x > axis.x1) continue;
    const float size = context.Scaled(9);
    Draw().AddTriangleFilled({x, y0}, {x + size, y0 + 0.5f * size}, {x, y0 + size},
                             colors::kWarning);
    Draw().AddLine({x, y0}, {x, y1}, colors::kWarning, context.Scaled(1.5));
  }
}

void DrawThumbnails(const FrameContext& context, const TimeAxis& axis, float y0, float y1) {
  const auto& thumbnails = context.shown_playback().history->thumbnails;
  Draw().AddRectFilled({axis.x0, y0}, {axis.x1, y1}, colors::kInset);
  if (thumbnails.empty()) return;
  const cv::Mat& any = thumbnails.front().image;
  const float height = y1 - y0 - context.Scaled(2);
  const float width = height * static_cast<float>(any.cols) / static_cast<float>(any.rows);
  Draw().PushClipRect({axis.x0, y0}, {axis.x1, y1}, true);
  const int newest = context.playback->newest_mapped_frame;
  for (float x = axis.x0; x < axis.x1; x += width + context.Scaled(2)) {
    const double middle = axis.FrameAt(x + 0.5f * width);
    if (middle > newest) break;
    const auto after = std::lower_bound(
        thumbnails.begin(), thumbnails.end(), middle,
        [](const FrameThumbnail& thumbnail, double frame) { return thumbnail.frame < frame; });
    auto nearest = after == thumbnails.end() ? std::prev(after) : after;
    if (nearest != thumbnails.begin() &&
        middle - std::prev(nearest)->frame < nearest->frame - middle)
      --nearest;
    const FrameThumbnail& thumbnail = *nearest;
    const ImTextureID texture = context.textures->Get(
        fmt::format("thumbnail {}", std::distance(thumbnails.begin(), nearest)),
        context.source_version * 1'000'003 + static_cast<std::uint64_t>(thumbnail.frame) + 1,
        [&] { return thumbnail.image; });
    Draw().AddImage(texture, {x, y0 + 1}, {x + width, y0 + 1 + height}, {0, 0}, {1, 1},
                    IM_COL32(255, 255, 255, 225));
  }
  Draw().PopClipRect();
}

void DrawPlayed(const FrameContext& context, const TimeAxis& axis, float y0, float y1) {
  const PlaybackView& playback = *context.playback;
  const float middle = 0.5f * (y0 + y1), half = context.Scaled(3);
  const auto clamped = [&](double frame) { return std::clamp(axis.XOf(frame), axis.x0, axis.x1); };
  const auto bar = [&](double from, double to, ImU32 color) {
    Draw().AddRectFilled({clamped(from), middle - half}, {clamped(to), middle + half}, color, half);
  };
  bar(axis.first, axis.last, colors::kInset);
  bar(0, std::max(playback.newest_mapped_frame, 0), colors::kControlHovered);
  bar(0, playback.frame, colors::kAccent);
  if (playback.range_begin || playback.range_end) {
    const float from = playback.range_begin ? clamped(*playback.range_begin) : axis.x0;
    const float to = playback.range_end ? clamped(*playback.range_end) : axis.x1;
    Draw().AddRect({from, y0}, {to, y1}, colors::kWarning, context.Scaled(2), 0,
                   context.Scaled(1.5));
  }
  if (playback.seek_target) {
    Draw().AddCircle({clamped(*playback.seek_target), middle}, context.Scaled(6), colors::kAccent,
                     0, context.Scaled(1.5));
  }
}

void DrawOptionMarks(const FrameContext& context, const TimeAxis& axis, const TimelineRows& rows) {
  for (const FrameEvent& event : *context.shown_playback().events) {
    if (event.event.kind != EventKind::kOptionsChanged) continue;
    const float x = axis.XOf(event.frame);
    if (x < axis.x0 || x > axis.x1) continue;
    const ImU32 color = EventColor(event.event.kind);
    const float y = 0.5f * (rows.bar + rows.lanes), size = context.Scaled(5);
    Draw().AddLine({x, rows.bar}, {x, rows.end}, WithAlpha(color, 0.6), context.Scaled(1));
    Draw().AddQuadFilled({x - size, y}, {x, y - size}, {x + size, y}, {x, y + size}, color);
  }
}

}  // namespace plumbline
