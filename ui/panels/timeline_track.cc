// SPDX-License-Identifier: Apache-2.0
#include "ui/panels/timeline_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace plumbline {
namespace {

constexpr float kBarHeight = 10, kRulerHeight = 16, kThumbnailHeight = 38, kLaneHeight = 13;
constexpr float kLeastPlotHeight = 34;

ImDrawList& Draw() { return *ImGui::GetWindowDrawList(); }

void Text(const FrameContext& context, ImVec2 at, ImU32 color, const std::string& text) {
  Draw().AddText(context.fonts.small, context.fonts.small->FontSize, at, color, text.c_str());
}

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

std::string TimeName(double seconds) {
  const int minutes = static_cast<int>(seconds / 60);
  return fmt::format("{}:{:05.2f}", minutes, seconds - 60 * minutes);
}

std::vector<ObjectLane> LanesOf(const std::vector<FrameEvent>& events, ObjectId also) {
  std::map<ObjectId, ObjectLane> by_id;
  ObjectLane others;
  for (const FrameEvent& event : events) {
    const LifeEvent& life = event.event;
    if (life.object.value <= 0) {
      others.events.push_back(&event);
      continue;
    }
    ObjectLane& lane = by_id[life.object];
    lane.id = life.object;
    if (life.kind == EventKind::kSpawned) lane.born = event.frame;
    if (life.kind == EventKind::kConfirmed && lane.confirmed < 0) lane.confirmed = event.frame;
    if (life.kind == EventKind::kRetired || life.kind == EventKind::kMerged)
      lane.ended = event.frame;
    lane.events.push_back(&event);
  }
  std::vector<ObjectLane> lanes;
  for (auto& [id, lane] : by_id) {
    if (lane.confirmed >= 0 || id == also) {
      lanes.push_back(std::move(lane));
    } else {
      others.events.insert(others.events.end(), lane.events.begin(), lane.events.end());
    }
  }
  if (!others.events.empty()) lanes.push_back(std::move(others));
  return lanes;
}

TrackRows PlanRows(const FrameContext& context, float top, float bottom, std::size_t lanes) {
  TrackRows rows;
  const float room = bottom - top;
  rows.ruler = top;
  float y = top + context.Scaled(kRulerHeight);
  rows.thumbnails = y;
  if (room > context.Scaled(130)) y += context.Scaled(kThumbnailHeight);
  rows.bar = y;
  y += context.Scaled(kBarHeight);
  rows.lanes = y;
  const float left = bottom - y;
  const float wanted = context.Scaled(kLaneHeight) * static_cast<float>(lanes);
  const bool plot = left > context.Scaled(kLeastPlotHeight + 2 * kLaneHeight);
  y += std::min(wanted,
                plot ? std::max(left - context.Scaled(kLeastPlotHeight), 0.5f * left) : left);
  rows.plot = plot && bottom - y > context.Scaled(24) ? y + context.Scaled(3) : bottom;
  if (!plot) rows.plot = bottom;
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
    Text(context, {x + context.Scaled(4), y0}, colors::kDimText, number);
    const std::string time = TimeName(frame / rate);
    const float time_x = x + context.Scaled(10) + WidthOf(context, number);
    if (time_x + WidthOf(context, time) < std::min(axis.XOf(frame + step), axis.x1))
      Text(context, {time_x, y0}, colors::kFaint, time);
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
  const auto& thumbnails = context.playback->history->thumbnails;
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

void DrawLanes(const FrameContext& context, const TimeAxis& axis, float label_x, float y0, float y1,
               const std::vector<ObjectLane>& lanes) {
  if (lanes.empty()) return;
  const float height =
      std::min(context.Scaled(kLaneHeight + 4), (y1 - y0) / static_cast<float>(lanes.size()));
  const float font = std::clamp(height, context.Scaled(10), context.fonts.small->FontSize);
  float labelled_to = -1e9f;  // labels keep off one another
  const float mark = 0.42f * height;
  Draw().PushClipRect({label_x, y0}, {axis.x1, y1}, true);
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const ObjectLane& lane = lanes[i];
    const float y = y0 + height * (static_cast<float>(i) + 0.5f);
    const bool all = lane.id.value <= 0;
    const ImU32 color = all ? colors::kFaint : ObjectColor(lane.id);
    if (!all && lane.id == context.selection.object)
      Draw().AddRectFilled({label_x, y - 0.5f * height}, {axis.x1, y + 0.5f * height},
                           colors::kControl);
    const int end = lane.ended >= 0 ? lane.ended : context.playback->newest_mapped_frame;
    const auto line = [&](int from, int to, float width, double alpha) {
      const float a = std::max(axis.XOf(from), axis.x0), b = std::min(axis.XOf(to), axis.x1);
      if (b > a)
        Draw().AddLine({a, y}, {b, y}, WithAlpha(color, alpha), std::max(1.0f, width * height));
    };
    if (!all) {
      line(lane.born, lane.confirmed >= 0 ? std::min(lane.confirmed, end) : end, 0.14f, 0.8);
      if (lane.confirmed >= 0) line(lane.confirmed, end, 0.5f, 0.75);
    }
    for (const FrameEvent* event : lane.events) {
      const float x = axis.XOf(event->frame);
      if (x < axis.x0 || x > axis.x1) continue;
      Draw().AddTriangleFilled({x - mark, y - mark}, {x + mark, y - mark}, {x, y + mark},
                               EventColor(event->event.kind));
    }
    const bool selected = !all && lane.id == context.selection.object;
    if (!selected && y - 0.45f * font < labelled_to) continue;
    labelled_to = y + 0.45f * font;
    const std::string name = all ? "never confirmed" : fmt::format("#{}", lane.id.value);
    Draw().AddText(context.fonts.small, font, {label_x, y - 0.5f * font},
                   all ? colors::kFaint : color, name.c_str());
  }
  Draw().PopClipRect();
}

}  // namespace plumbline
