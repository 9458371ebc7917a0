// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/image/overlays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/snapshot/map_snapshot.h"
#include "ui/framework/particle_place.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

std::optional<ImVec2> Project(const SequenceView& sequence, const Eigen::Isometry3d& cam_from_world,
                              const Eigen::Vector3d& point_in_world, const ImageCanvas& canvas) {
  const Eigen::Vector3d p = cam_from_world * point_in_world;
  if (p.z() < 0.05) return std::nullopt;
  return canvas.ToScreen(static_cast<float>(sequence.fx * p.x() / p.z() + sequence.cx),
                         static_cast<float>(sequence.fy * p.y() / p.z() + sequence.cy));
}

const ObjectReport* ObjectOf(const FrameContext& context, ObjectId id) {
  for (const ObjectReport& object : context.snapshot->report.objects) {
    if (object.id == id) return &object;
  }
  return nullptr;
}

/// 0 where there is none.
int IdAt(const FrameContext& context, const Eigen::Vector2f& pixel) {
  const cv::Mat& id = context.snapshot->id;
  if (id.empty()) return 0;
  const auto map = [](float value, int from, int to) {
    return static_cast<int>(
        std::floor((value + 0.5f) * static_cast<float>(to) / static_cast<float>(from)));
  };
  const int x = map(pixel.x(), context.sequence->image_width, id.cols);
  const int y = map(pixel.y(), context.sequence->image_height, id.rows);
  if (x < 0 || y < 0 || x >= id.cols || y >= id.rows) return 0;
  return id.at<std::uint16_t>(y, x);
}

}  // namespace

std::vector<ObjectId> LeftOut(const FrameContext& context) {
  std::vector<ObjectId> ids;
  if (!context.confirmed_only) return ids;
  for (const ObjectReport& object : context.snapshot->report.objects) {
    if (!context.Shows(object)) ids.push_back(object.id);
  }
  return ids;
}

std::uint64_t VersionOfShown(const FrameContext& context, const std::vector<ObjectId>& left_out) {
  // Both versions only grow; the hash is FNV-1a's.
  std::uint64_t hash = 14695981039346656037u;
  const auto mix = [&](std::uint64_t value) { hash = (hash ^ value) * 1099511628211u; };
  mix(context.snapshot_version + context.looks_version);
  for (const ObjectId id : left_out) mix(static_cast<std::uint64_t>(id.value));
  return hash;
}

cv::Mat WithoutObjects(const cv::Mat& map, const cv::Mat& id,
                       const std::vector<ObjectId>& left_out) {
  if (left_out.empty() || map.empty() || map.size() != id.size()) return map;
  cv::Mat hidden(id.size(), CV_8U);
  for (int y = 0; y < id.rows; ++y) {
    const auto* ids = id.ptr<std::uint16_t>(y);
    auto* out = hidden.ptr<std::uint8_t>(y);
    int last = 0;
    std::uint8_t hide = 0;
    for (int x = 0; x < id.cols; ++x) {
      if (ids[x] != last) {
        last = ids[x];
        hide =
            std::find(left_out.begin(), left_out.end(), ObjectId{last}) != left_out.end() ? 255 : 0;
      }
      out[x] = hide;
    }
  }
  cv::Mat shown = map.clone();
  shown.setTo(0, hidden);
  return shown;
}

int DrawParticleOverlay(const FrameContext& context, const ImageCanvas& canvas,
                        const ObjectReport& object, const ParticleOverlay& overlay) {
  if (object.particles == nullptr || !context.snapshot->report.world_from_cam) return -1;
  const SequenceView& sequence = *context.sequence;
  const Eigen::Isometry3d cam_from_world = context.snapshot->report.world_from_cam->inverse();
  const UprightFrame upright(-sequence.up_in_world);
  double heaviest = -1e9;
  for (const Particle& p : *object.particles) heaviest = std::max<double>(heaviest, p.log_weight);
  const double needle_m = NeedleLength(context.Model(object.label));
  const ImU32 color = context.ColorOf(object.id);
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const float radius = context.Scaled(overlay.radius_px);
  int nearest = -1;
  float nearest_px = context.Scaled(6);
  for (std::size_t i = 0; i < object.particles->size(); ++i) {
    const Particle& particle = (*object.particles)[i];
    const ParticlePlace place = PlaceOf(particle, object, upright);
    const auto center = Project(sequence, cam_from_world, place.center_in_world, canvas);
    if (!center) continue;
    const double light = std::exp(std::max(-4.0, particle.log_weight - heaviest));
    const bool chosen = static_cast<int>(i) == context.selection.particle;
    const ImU32 ink =
        chosen ? IM_COL32_WHITE
               : WithAlpha(Mixed(color, IM_COL32_WHITE, 0.35 * light), 0.35 + 0.55 * light);
    if (overlay.fronts) {
      const auto tip = Project(sequence, cam_from_world,
                               place.center_in_world + needle_m * place.heading_in_world, canvas);
      if (tip)
        canvas.draw().AddLine(*center, *tip, WithAlpha(ink, chosen ? 1.0 : 0.45),
                              context.Scaled(chosen ? 2 : 1));
    }
    canvas.draw().AddCircleFilled(*center, chosen ? 2 * radius : radius, ink, 8);
    const float distance = std::hypot(center->x - mouse.x, center->y - mouse.y);
    if (canvas.hovered() && distance < nearest_px) {
      nearest = static_cast<int>(i);
      nearest_px = distance;
    }
  }
  return nearest;
}

void DrawOutlineOverlay(const FrameContext& context, const ImageCanvas& canvas,
                        const OutlineOverlay& overlay) {
  std::vector<ImVec2> points;
  for (const OutlineView& outline : context.snapshot->outlines) {
    if (overlay.only.value > 0 && outline.object != overlay.only) continue;
    const ObjectReport* object = ObjectOf(context, outline.object);
    if (object != nullptr && !context.Shows(*object)) continue;
    const bool selected = outline.object == context.selection.object;
    const bool tentative =
        object != nullptr && object->state == ObjectState::kTentative && !selected;
    const float width = context.Scaled(overlay.width_px * (selected ? 1.6 : tentative ? 0.6 : 1.0));
    const double alpha = overlay.alpha * (tentative ? 0.3 + GhostShare(object->log_evidence) : 1.0);
    const bool dashed = context.LookOf(outline.object).dashed;
    for (const auto& contour : outline.contours) {
      points.clear();
      for (const Eigen::Vector2f& p : contour) points.push_back(canvas.ToScreen(p));
      if (points.empty()) continue;
      points.push_back(points.front());
      const int count = static_cast<int>(points.size());
      if (overlay.shadow && !tentative) {
        canvas.draw().AddPolyline(points.data(), count, IM_COL32(0, 0, 0, 140), 0,
                                  width + context.Scaled(2));
      }
      Polyline(context, canvas.draw(), points, WithAlpha(context.ColorOf(outline.object), alpha),
               width, dashed);
    }
  }
}

const ProbeView* ProbeOfSelection(const FrameContext& context) {
  const ProbeView* probe = context.probe.get();
  const bool fits = probe != nullptr && context.snapshot != nullptr &&
                    probe->frame == context.snapshot->report.frame &&
                    probe->object == context.selection.object &&
                    probe->truth == context.selection.truth;
  return fits ? probe : nullptr;
}

void DrawContourOverlay(const FrameContext& context, const ImageCanvas& canvas) {
  const ProbeView* probe = ProbeOfSelection(context);
  if (probe == nullptr || probe->hypotheses.empty()) return;
  const auto index = static_cast<std::size_t>(
      std::clamp(context.selection.hypothesis, 0, static_cast<int>(probe->hypotheses.size()) - 1));
  const float dot = context.Scaled(2);
  for (const ContourSample& sample : probe->hypotheses[index].samples) {
    const Eigen::Vector2f reach = probe->search_radius_px * sample.normal;
    const ImU32 color = sample.visible
                            ? Mixed(colors::kBad, colors::kGood, std::min(1.0, 1.6 * sample.hit))
                            : colors::kFaint;
    canvas.draw().AddLine(canvas.ToScreen(Eigen::Vector2f(sample.pixel - reach)),
                          canvas.ToScreen(Eigen::Vector2f(sample.pixel + reach)),
                          WithAlpha(color, sample.visible ? 0.45 : 0.2), 1);
    canvas.draw().AddRectFilled(
        {canvas.ToScreen(sample.pixel).x - 1, canvas.ToScreen(sample.pixel).y - 1},
        {canvas.ToScreen(sample.pixel).x + 1, canvas.ToScreen(sample.pixel).y + 1}, color);
    if (!sample.visible || !sample.edge_at_px) continue;
    canvas.draw().AddCircleFilled(
        canvas.ToScreen(Eigen::Vector2f(sample.pixel + *sample.edge_at_px * sample.normal)), dot,
        color, 6);
  }
}

void DrawParticleOutline(const FrameContext& context, const ImageCanvas& canvas) {
  const ProbeView* probe = ProbeOfSelection(context);
  if (probe == nullptr) return;
  const std::vector<std::vector<Eigen::Vector2f>>* outline = nullptr;
  for (const ProbedHypothesis& h : probe->hypotheses) {
    if (context.selection.particle >= 0 && h.particle == context.selection.particle)
      outline = &h.outline;
  }
  if (context.selection.hovered >= 0 && probe->hovered == context.selection.hovered)
    outline = &probe->hovered_outline;
  if (outline == nullptr) return;
  std::vector<ImVec2> points;
  for (const auto& contour : *outline) {
    points.clear();
    for (const Eigen::Vector2f& p : contour) points.push_back(canvas.ToScreen(p));
    const int count = static_cast<int>(points.size());
    canvas.draw().AddPolyline(points.data(), count, IM_COL32(0, 0, 0, 160), ImDrawFlags_Closed,
                              context.Scaled(3.5));
    canvas.draw().AddPolyline(points.data(), count, IM_COL32_WHITE, ImDrawFlags_Closed,
                              context.Scaled(1.5));
  }
}

void DrawPixelValue(const FrameContext& context, const ImageCanvas& canvas) {
  const cv::Mat& image = context.snapshot->image;
  const auto pixel = canvas.hovered();
  if (!pixel || image.empty()) return;
  const int width = context.sequence->image_width, height = context.sequence->image_height;
  const int x = static_cast<int>(std::lround(pixel->x())),
            y = static_cast<int>(std::lround(pixel->y()));
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  // A run without its sequence has small pictures only.
  const auto& bgr = image.at<cv::Vec3b>(y * image.rows / height, x * image.cols / width);
  std::string text = fmt::format("x {}  y {}   rgb {} {} {}", x, y, bgr[2], bgr[1], bgr[0]);
  const cv::Mat& depth = context.snapshot->depth;
  const ObjectId at = ObjectAt(context, *pixel);
  const bool left_out = at.value <= 0 && IdAt(context, *pixel) > 0;
  if (!depth.empty() && !left_out) {
    const float z = depth.at<float>(y * depth.rows / height, x * depth.cols / width);
    if (z > 0) text += fmt::format("   {:.2f} m", z);
  }
  if (const ObjectReport* object = ObjectOf(context, at)) {
    const ModelView* model = context.Model(object->label);
    text += fmt::format("   #{} {}", object->id.value,
                        model != nullptr ? model->name : object->category);
  }
  PictureLabels labels(context, canvas.low(), canvas.high());
  labels.Add({canvas.low()}, colors::kOnPicture, text);
}

ObjectId ObjectAt(const FrameContext& context, const Eigen::Vector2f& pixel) {
  const int id = IdAt(context, pixel);
  if (id <= 0) return {};
  const ObjectReport* object = ObjectOf(context, {id});
  return object == nullptr || context.Shows(*object) ? ObjectId{id} : ObjectId{};
}

void DrawTrackOverlay(const FrameContext& context, const ImageCanvas& canvas) {
  constexpr float kNearMouse_px = 6;
  const OwnPoses* poses = context.sequence->own_poses.get();
  const auto at = static_cast<std::size_t>(context.snapshot->report.frame);
  if (poses == nullptr || at >= poses->frames.size()) return;
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const TrackReport* hovered = nullptr;
  for (const TrackReport& track : poses->frames[at].tracks) {
    const ImU32 color = track.state == TrackState::kInState    ? colors::kGood
                        : track.state == TrackState::kRejected ? colors::kBad
                                                               : colors::kOnPictureDim;
    const ImVec2 point = canvas.ToScreen(track.pixel);
    const float radius = context.Scaled(1.5 + 0.5 * std::min(3.0, track.age / 10.0));
    canvas.draw().AddCircleFilled(point, radius + context.Scaled(1), IM_COL32(0, 0, 0, 140), 10);
    canvas.draw().AddCircleFilled(point, radius, color, 10);
    if (std::hypot(mouse.x - point.x, mouse.y - point.y) < context.Scaled(kNearMouse_px))
      hovered = &track;
  }
  if (hovered == nullptr || !canvas.hovered()) return;
  const auto state = static_cast<std::size_t>(hovered->state);
  std::string text = fmt::format("track {}, {}\nseen in {} images before", hovered->id,
                                 EnumNames<TrackState>::names[state], hovered->age);
  if (hovered->state != TrackState::kFollowed)
    text += fmt::format("\n{:.1f} px from where the filter expects it", hovered->residual_px);
  const ImVec2 point = canvas.ToScreen(hovered->pixel);
  const float around = context.Scaled(2 * kNearMouse_px);
  PutTooltipBeside(context, {point.x - around, point.y - around},
                   {point.x + around, point.y + around});
  ImGui::SetTooltip("%s", text.c_str());
}

}  // namespace plumbline
