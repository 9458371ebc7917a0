// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/timeline_lanes.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "ui/framework/widgets.h"

namespace plumbline {

std::vector<ObjectLane> LanesOf(const std::vector<FrameEvent>& events, ObjectId also,
                                bool confirmed_only) {
  std::map<ObjectId, ObjectLane> by_id;
  ObjectLane others;
  for (const FrameEvent& event : events) {
    const LifeEvent& life = event.event;
    if (life.kind == EventKind::kOptionsChanged) continue;  // marked over all lanes
    if (life.object.value <= 0) {
      others.events.push_back(&event);
      continue;
    }
    ObjectLane& lane = by_id[life.object];
    lane.id = life.object;
    if (life.kind == EventKind::kSpawned) lane.spawned = event.frame;
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
  if (!others.events.empty() && !confirmed_only) lanes.push_back(std::move(others));
  return lanes;
}

TruthLane TruthLaneOf(const RunHistory& history, const std::string& id, std::size_t index) {
  using Kind = TruthLane::Span::Kind;
  TruthLane lane{index, id, {}};
  std::map<Kind, std::size_t> open;  // the newest span of each kind
  int before = -1;                   // the frame before
  const auto extend = [&](Kind kind, int frame, ObjectId object) {
    const auto last = open.find(kind);
    if (last != open.end() && lane.spans[last->second].to == before &&
        lane.spans[last->second].object == object) {
      lane.spans[last->second].to = frame;
      return;
    }
    open[kind] = lane.spans.size();
    lane.spans.push_back({kind, frame, frame, object});
  };
  for (const auto& frame : history.frames) {
    if (frame == nullptr || index >= frame->truths.size()) continue;
    const TruthSample& truth = frame->truths[index];
    if (truth.visible_px > 0) extend(Kind::kSeen, frame->frame, {});
    if (truth.box_fate) extend(Kind::kBoxed, frame->frame, {});
    if (truth.object.value > 0)
      extend(truth.confirmed ? Kind::kConfirmed : Kind::kTentative, frame->frame, truth.object);
    before = frame->frame;
  }
  return lane;
}

void TimelineLanes::Update(const FrameContext& context, bool all_truths) {
  UpdateTruths(context, all_truths);
  const PlaybackView& playback = context.shown_playback();
  const bool changed = events_ != playback.events || lane_for_ != context.selection.object ||
                       confirmed_only_ != context.confirmed_only;
  if (changed) {
    events_ = playback.events;
    lane_for_ = context.selection.object;
    confirmed_only_ = context.confirmed_only;
    lanes_ = LanesOf(*events_, lane_for_, confirmed_only_);
  }
  if (!changed && history_ == playback.history) return;
  history_ = playback.history;
  NameLanes(context);
}

void TimelineLanes::UpdateTruths(const FrameContext& context, bool all) {
  const auto truths = context.truths;
  if (of_truths_ == truths && truth_for_ == context.selection.truth && all_truths_ == all) return;
  of_truths_ = truths;
  truth_for_ = context.selection.truth;
  all_truths_ = all;
  truths_.clear();
  for (std::size_t i = 0; truths != nullptr && i < truths->truths.size(); ++i) {
    const TruthView& truth = truths->truths[i];
    if (all || !truth.found || truth.id == truth_for_)
      truths_.push_back(TruthLaneOf(*context.shown_playback().history, truth.id, i));
  }
}

/// By the last shape that the history knows of each.
void TimelineLanes::NameLanes(const FrameContext& context) {
  std::size_t missing = 0;
  for (ObjectLane& lane : lanes_) {
    lane.name = lane.id.value <= 0 ? "never confirmed" : fmt::format("#{}", lane.id.value);
    missing += lane.id.value > 0;
  }
  std::map<ObjectId, ModelId> labels;
  for (auto frame = history_->frames.rbegin();
       frame != history_->frames.rend() && labels.size() < missing; ++frame) {
    if (*frame == nullptr) continue;
    for (const ObjectSample& object : (*frame)->objects) {
      const bool wanted = std::any_of(lanes_.begin(), lanes_.end(),
                                      [&](const ObjectLane& lane) { return lane.id == object.id; });
      if (wanted) labels.emplace(object.id, object.label);
    }
  }
  for (ObjectLane& lane : lanes_) {
    const auto label = labels.find(lane.id);
    const ModelView* model = label != labels.end() ? context.Model(label->second) : nullptr;
    if (model != nullptr) lane.name += " " + model->name;
  }
}

void TimelineLanes::Scroll(const FrameContext& context, float view_height) {
  const float height = context.Scaled(kLaneHeight);
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsItemHovered()) scroll_ -= 2 * height * io.MouseWheel;
  if (ImGui::IsItemActive() && ImGui::IsMouseDragging(ImGuiMouseButton_Left))
    scroll_ -= io.MouseDelta.y;
  if (seen_ != context.selection.object) {
    seen_ = context.selection.object;
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      if (lanes_[i].id != seen_) continue;
      const float top = height * static_cast<float>(i);
      scroll_ = std::clamp(scroll_, top + height - view_height, top);
    }
  }
  if (truth_seen_ != context.selection.truth) {
    truth_seen_ = context.selection.truth;
    for (std::size_t i = 0; i < truths_.size(); ++i) {
      if (truths_[i].id != truth_seen_) continue;
      const float top = height * static_cast<float>(lanes_.size() + i);
      scroll_ = std::clamp(scroll_, top + height - view_height, top);
    }
  }
  const float all = height * static_cast<float>(size());
  scroll_ = std::clamp(scroll_, 0.0f, std::max(0.0f, all - view_height));
}

void TimelineLanes::Draw(const FrameContext& context, const TimeAxis& axis, float label_x, float y0,
                         float y1, CommandSink& sink) {
  const float height = context.Scaled(kLaneHeight);
  if (size() == 0 || y1 - y0 < 1) return;
  const ImVec2 cursor = ImGui::GetCursorScreenPos();
  ImGui::SetCursorScreenPos({label_x, y0});
  ImGui::InvisibleButton("timeline.lanes", {axis.x0 - context.Scaled(6) - label_x, y1 - y0});
  LogItem(context, "timeline.lanes");
  Scroll(context, y1 - y0);
  const bool hovered = ImGui::IsItemHovered(),
             clicked = ImGui::IsItemDeactivated() && hovered &&
                       ImGui::GetIO().MouseDragMaxDistanceSqr[0] < 16;
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect({label_x, y0}, {axis.x1, y1}, true);
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    const ObjectLane& lane = lanes_[i];
    const float top = y0 + height * static_cast<float>(i) - scroll_;
    if (top + height < y0 || top > y1) continue;
    DrawLane(context, axis, lane, label_x, top + 0.5f * height);
    if (lane.id.value <= 0) continue;
    if (top >= y0 - 0.5f && top + height <= y1 + 0.5f)
      context.widgets->Add(fmt::format("timeline.lane.{}", lane.id.value), {label_x, top},
                           {axis.x0, top + height});
    const float mouse = ImGui::GetIO().MousePos.y;
    if (mouse < top || mouse >= top + height) continue;
    if (clicked) sink.Post(SelectObjectCommand{lane.id});
    if (hovered) Tooltip(context, lane.name + "\nA click selects it; the wheel scrolls.");
  }
  for (std::size_t i = 0; i < truths_.size(); ++i) {
    const TruthLane& lane = truths_[i];
    const float top = y0 + height * static_cast<float>(lanes_.size() + i) - scroll_;
    if (top + height < y0 || top > y1) continue;
    DrawTruthLane(context, axis, lane, label_x, top + 0.5f * height);
    if (top >= y0 - 0.5f && top + height <= y1 + 0.5f)
      context.widgets->Add("timeline.truth." + lane.id, {label_x, top}, {axis.x0, top + height});
    const float mouse = ImGui::GetIO().MousePos.y;
    if (mouse < top || mouse >= top + height) continue;
    if (clicked) sink.Post(SelectTruthCommand{lane.id});
    if (hovered && lane.index < of_truths_->truths.size())
      Tooltip(context, lane.id + ", a true object. " + of_truths_->truths[lane.index].text +
                           "\nThin: it shows; dots above: a box lies over it; thick: the object "
                           "that it is paired with. A click selects it.");
  }
  draw.PopClipRect();
  DrawScrollBar(context, axis.x0 - context.Scaled(10), y0, y1);
  ImGui::SetCursorScreenPos(cursor);
}

void TimelineLanes::DrawLane(const FrameContext& context, const TimeAxis& axis,
                             const ObjectLane& lane, float label_x, float y) const {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float height = context.Scaled(kLaneHeight), mark = 0.3f * height;
  const bool all = lane.id.value <= 0;
  const ImU32 color = all ? colors::kFaint : OnPanel(context.ColorOf(lane.id));
  if (!all && lane.id == context.selection.object)
    draw.AddRectFilled({label_x, y - 0.5f * height}, {axis.x1, y + 0.5f * height},
                       colors::kControl);
  const int end = lane.ended >= 0 ? lane.ended : context.shown_playback().newest_mapped_frame;
  const auto line = [&](int from, int to, float width, double alpha) {
    const float a = std::max(axis.XOf(from), axis.x0), b = std::min(axis.XOf(to), axis.x1);
    if (b <= a) return;
    const ImVec2 ends[] = {{a, y}, {b, y}};
    Polyline(context, draw, ends, WithAlpha(color, alpha), context.Scaled(width),
             !all && context.LookOf(lane.id).dashed);
  };
  if (!all) {
    line(lane.spawned, lane.confirmed >= 0 ? std::min(lane.confirmed, end) : end, 2, 0.8);
    if (lane.confirmed >= 0) line(lane.confirmed, end, 7, 0.75);
  }
  for (const FrameEvent* event : lane.events) {
    const float x = axis.XOf(event->frame);
    if (x < axis.x0 || x > axis.x1) continue;
    draw.AddTriangleFilled({x - mark, y - mark}, {x + mark, y - mark}, {x, y + mark},
                           EventColor(event->event.kind));
  }
  const ImFont* font = context.fonts.small;
  const ImVec4 clip(label_x, y - height, axis.x0 - context.Scaled(14), y + height);
  float x = label_x;
  if (!all) x += DrawChip(context, draw, {x, y - 0.5f * font->FontSize}, lane.id);
  draw.AddText(font, font->FontSize, {x, y - 0.5f * font->FontSize},
               all ? colors::kFaint : colors::kText, lane.name.c_str(), nullptr, 0, &clip);
}

void TimelineLanes::DrawTruthLane(const FrameContext& context, const TimeAxis& axis,
                                  const TruthLane& lane, float label_x, float y) {
  using Kind = TruthLane::Span::Kind;
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float height = context.Scaled(kLaneHeight);
  if (lane.id == context.selection.truth)
    draw.AddRectFilled({label_x, y - 0.5f * height}, {axis.x1, y + 0.5f * height},
                       colors::kControl);
  for (const TruthLane::Span& span : lane.spans) {
    const float a = std::max(axis.XOf(span.from - 0.5), axis.x0);
    const float b = std::min(axis.XOf(span.to + 0.5), axis.x1);
    if (b <= a) continue;
    switch (span.kind) {
      case Kind::kSeen:
        draw.AddLine({a, y}, {b, y}, WithAlpha(OnPanel(colors::kTruth), 0.7), context.Scaled(1.5));
        break;
      case Kind::kBoxed: {
        const float top = y - 0.36f * height;
        draw.AddLine({a, top}, {std::max(b, a + 1), top}, colors::kDimText, context.Scaled(2));
        break;
      }
      case Kind::kTentative:
        draw.AddLine({a, y}, {b, y}, WithAlpha(OnPanel(context.ColorOf(span.object)), 0.9),
                     context.Scaled(3));
        break;
      case Kind::kConfirmed:
        draw.AddLine({a, y}, {b, y}, WithAlpha(OnPanel(context.ColorOf(span.object)), 0.75),
                     context.Scaled(7));
        break;
    }
  }
  const ImFont* font = context.fonts.small;
  const ImVec4 clip(label_x, y - height, axis.x0 - context.Scaled(14), y + height);
  draw.AddText(font, font->FontSize, {label_x, y - 0.5f * font->FontSize}, OnPanel(colors::kTruth),
               lane.id.c_str(), nullptr, 0, &clip);
}

void TimelineLanes::DrawScrollBar(const FrameContext& context, float x, float y0, float y1) const {
  const float all = context.Scaled(kLaneHeight) * static_cast<float>(size());
  if (all <= y1 - y0 + 1) return;
  const float low = y0 + (y1 - y0) * scroll_ / all, high = low + (y1 - y0) * (y1 - y0) / all;
  ImGui::GetWindowDrawList()->AddRectFilled({x, low}, {x + context.Scaled(4), high},
                                            colors::kControlHovered, context.Scaled(2));
}

}  // namespace plumbline
