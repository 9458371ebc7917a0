// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/map/scene_overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "engine/geometry/symmetric_matrix.h"
#include "engine/snapshot/belief_tails.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kNear_m = 0.05;
constexpr double kGaussian95 = 2.795;  ///< Radius of the 95 % region of a Gaussian in 3-D,
constexpr double kBelief95 = 3.144;    ///< and of Student's t of four degrees of freedom.
static_assert(kBeliefDegreesOfFreedom == 4);
constexpr double kWorstError_m = 0.1;  ///< Red from here on.

Eigen::Vector3d CenterOf(const FrameContext& context, const ObjectReport& object) {
  const ModelView* model = context.Model(object.label);
  if (model == nullptr) return object.world_from_object.translation();
  return object.world_from_object * (object.scale * model->center);
}

/// The outline of the ellipsoid, from the projections of its axes.
void DrawSpread(const FrameContext& context, const SceneProjection& project,
                const Eigen::Vector3d& center, const Eigen::Matrix3d& covariance, double radius,
                ImU32 color) {
  const auto [variances, axes] = EigenOf(covariance);
  const auto middle = project(center);
  if (!middle) return;
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const double reach = radius * std::sqrt(std::max(0.0, variances[axis]));
    const auto tip = project(center + reach * axes.col(axis));
    if (!tip) return;
    const Eigen::Vector2d d(tip->x - middle->x, tip->y - middle->y);
    square += d * d.transpose();
  }
  const auto [squares, directions] = EigenOf(square);
  const Eigen::Matrix2d shape = directions * squares.cwiseMax(2.0).cwiseSqrt().asDiagonal();
  std::array<ImVec2, 40> points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double angle = 2 * 3.14159265358979 * static_cast<double>(i) / points.size();
    const Eigen::Vector2d p = shape * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    points[i] = {middle->x + static_cast<float>(p.x()), middle->y + static_cast<float>(p.y())};
  }
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddConvexPolyFilled(points.data(), static_cast<int>(points.size()), WithAlpha(color, 0.25));
  draw.AddPolyline(points.data(), static_cast<int>(points.size()), color, ImDrawFlags_Closed,
                   context.Scaled(1.5));
}

/// The bounds of confirmed objects, a little larger: a point in them is explained by its model.
class ExplainedSpace {
 public:
  explicit ExplainedSpace(const FrameContext& context) {
    for (const ObjectReport& object : context.snapshot->report.objects) {
      const ModelView* model = context.Model(object.label);
      if (object.state == ObjectState::kConfirmed && model != nullptr)
        places_.push_back({object.world_from_object.inverse().cast<float>(),
                           Scaled(model->bounds, object.scale).cast<float>()});
    }
  }
  bool Holds(const Eigen::Vector3f& point) const {
    return std::any_of(places_.begin(), places_.end(), [&](const auto& place) {
      return place.second.squaredExteriorDistance(place.first * point) < kInModel_m * kInModel_m;
    });
  }

 private:
  static constexpr float kInModel_m = 0.04f;
  std::vector<std::pair<Eigen::Isometry3f, Eigen::AlignedBox3f>> places_;
};

/// Points that the filter has finished, up to the frame that shows: what was seen, where no model
/// explains it.
void DrawPoints(const FrameContext& context, const SceneProjection& project,
                const std::optional<ClipBox>& clip) {
  constexpr int kMost = 6000;  // the newest
  const auto& frames = context.sequence->own_poses->frames;
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ExplainedSpace explained(context);
  const float half = 0.5f * context.Scaled(1.6);
  int drawn = 0;
  for (std::size_t i =
           std::min(frames.size(), static_cast<std::size_t>(context.snapshot->report.frame) + 1);
       i-- > 0 && drawn < kMost;) {
    for (const Eigen::Vector3f& point : frames[i].points_in_world) {
      const auto at = project(point.cast<double>());
      if (!at || explained.Holds(point) || (clip && !clip->Holds(point.cast<double>()))) continue;
      draw.AddRectFilled({at->x - half, at->y - half}, {at->x + half, at->y + half},
                         WithAlpha(colors::kOnPicture, 0.65));
      ++drawn;
    }
  }
}

/// 95 % of the belief about where the camera is, relative to where the filter began.
void DrawCameraSpread(const FrameContext& context, const SceneProjection& project) {
  const auto& frames = context.sequence->own_poses->frames;
  const auto at = static_cast<std::size_t>(context.snapshot->report.frame);
  if (at >= frames.size() || !frames[at].world_from_cam || context.look_through) return;
  DrawSpread(context, project, frames[at].world_from_cam->translation(),
             frames[at].cam_covariance.topLeftCorner<3, 3>(), kGaussian95, colors::kTrajectory);
}

ImU32 LinkColor(RelationKind kind) {
  return kind == RelationKind::kStandsOn ? colors::kGood
         : kind == RelationKind::kHides  ? colors::kWarning
                                         : colors::kAccent;
}

Eigen::Vector3d MiddleOf(const FrameContext& context, const SequenceView::Truth& truth) {
  for (const ModelView& model : context.sequence->models) {
    if (model.name == truth.model) return truth.world_from_object * (truth.scale * model.center);
  }
  return truth.world_from_object.translation();
}

/// The edges of the bounding box of its model.
void DrawTruthBox(const FrameContext& context, const SceneProjection& project,
                  const SequenceView::Truth& truth) {
  for (const ModelView& model : context.sequence->models) {
    if (model.name != truth.model || model.bounds.isEmpty()) continue;
    std::array<std::optional<ImVec2>, 8> corners;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3f corner =
          model.bounds.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i));
      corners[static_cast<std::size_t>(i)] =
          project(truth.world_from_object * (truth.scale * corner.cast<double>()));
    }
    for (std::size_t i = 0; i < 8; ++i) {
      for (const std::size_t bit : {1u, 2u, 4u}) {  // neighbours differ in one axis
        const std::size_t j = i | bit;
        if (j == i || !corners[i] || !corners[j]) continue;
        ImGui::GetWindowDrawList()->AddLine(*corners[i], *corners[j], colors::kTruth,
                                            context.Scaled(2));
      }
    }
  }
}

void DrawTruths(const FrameContext& context, const SceneProjection& project,
                const SceneOverlay& overlay, ImVec2 low, ImVec2 high, PictureLabels& labels) {
  for (const SequenceView::Truth& truth : context.sequence->truth) {
    const bool selected = truth.id == context.selection.truth;
    if (selected) DrawTruthBox(context, project, truth);
    if (!overlay.truth_names && !selected) continue;
    if (overlay.clip && !overlay.clip->Holds(MiddleOf(context, truth))) continue;
    const auto at = project(MiddleOf(context, truth));
    if (!at || at->x < low.x || at->x > high.x || at->y < low.y || at->y > high.y) continue;
    const ImVec2 size = labels.SizeOf(truth.id);
    const float x = at->x - 0.5f * size.x, y = at->y + 0.5f * size.y;
    labels.Add({{x, y}, {x, y + 1.15f * size.y}, {x, y - 1.15f * size.y}}, colors::kTruth, truth.id,
               PictureLabels::Need::kIfFree);
    context.widgets->Add("scene.truth." + truth.id, {at->x - 2, at->y - 2}, {at->x + 2, at->y + 2});
  }
}

}  // namespace

const char* ColoringName(SceneColoring coloring) {
  static constexpr const char* kNames[] = {"identity", "own", "state", "error", "on truth"};
  return kNames[static_cast<std::size_t>(coloring)];
}

std::vector<SceneObject> SceneObjectsOf(const FrameContext& context, SceneColoring coloring,
                                        double opacity) {
  std::vector<SceneObject> objects;
  if (context.snapshot == nullptr) return objects;
  const FrameReport& report = context.snapshot->report;
  std::map<ObjectId, float> errors;
  if (coloring == SceneColoring::kError) {
    for (const auto& frame : context.shown_playback().history->frames) {
      if (frame == nullptr || frame->frame != report.frame) continue;
      for (const ObjectSample& sample : frame->objects) {
        if (sample.error) errors[sample.id] = sample.error->translation_m;
      }
    }
  }
  for (const ObjectReport& object : report.objects) {
    if (object.state == ObjectState::kRetired || !context.Shows(object)) continue;
    SceneObject drawn{object.id, context.ColorOf(object.id), static_cast<float>(opacity)};
    switch (coloring) {
      case SceneColoring::kIdentity:
      case SceneColoring::kOwn:
        break;
      case SceneColoring::kState:
        drawn.color = StateColor(object.state);
        break;
      case SceneColoring::kError: {
        const auto error = errors.find(object.id);
        drawn.color = error == errors.end() ? colors::kFaint
                                            : Mixed(colors::kGood, colors::kBad,
                                                    std::min(1.0, error->second / kWorstError_m));
        break;
      }
      case SceneColoring::kOnTruth:
        drawn.color = colors::kTruth;
        break;
    }
    if (object.state == ObjectState::kTentative)
      drawn.opacity *= static_cast<float>(GhostShare(object.log_evidence));
    objects.push_back(drawn);
  }
  return objects;
}

SceneProjection::SceneProjection(const FrameContext& context, const SceneCamera& camera, ImVec2 low,
                                 ImVec2 high)
    : context_(context) {
  const double width = high.x - low.x, height = std::max(1.0f, high.y - low.y);
  const SequenceView& sequence = *context.sequence;
  if (context.look_through && context.snapshot->report.world_from_cam && sequence.fx > 0) {
    view_from_world_ = context.snapshot->report.world_from_cam->inverse();
    const double image_aspect = double(sequence.image_width) / sequence.image_height;
    const double half_height =
        0.5 * sequence.image_height / sequence.fy * std::max(1.0, image_aspect * height / width);
    const double per_pixel = 0.5 * height / half_height / sequence.fy;
    focal_ = Eigen::Vector2d(sequence.fx, sequence.fy) * per_pixel;
    middle_ = Eigen::Vector2d(
        0.5 * (low.x + high.x) + (sequence.cx - 0.5 * (sequence.image_width - 1)) * per_pixel,
        0.5 * (low.y + high.y) + (sequence.cy - 0.5 * (sequence.image_height - 1)) * per_pixel);
    return;
  }
  // From x right, y up, z to the viewer.
  Eigen::Matrix3d down = Eigen::Vector3d(1, -1, -1).asDiagonal();
  view_from_world_.linear() = down * camera.view_from_world;
  const Eigen::Vector3d eye =
      camera.focus_in_world + camera.distance_m * camera.view_from_world.row(2).transpose();
  view_from_world_.translation() = -(view_from_world_.linear() * eye);
  parallel_ = camera.parallel;
  focal_.setConstant(0.5 * height / std::tan(0.5 * camera.view_angle_rad) /
                     (parallel_ ? camera.distance_m : 1.0));
  middle_ = Eigen::Vector2d(0.5 * (low.x + high.x), 0.5 * (low.y + high.y));
}

std::optional<ImVec2> SceneProjection::operator()(const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d p = view_from_world_ * point_in_world;
  if (!parallel_ && p.z() < kNear_m) return std::nullopt;
  const double depth = parallel_ ? 1 : p.z();
  return ImVec2(static_cast<float>(middle_.x() + focal_.x() * p.x() / depth),
                static_cast<float>(middle_.y() + focal_.y() * p.y() / depth));
}

SightLine SceneProjection::Sight(ImVec2 point) const {
  const Eigen::Isometry3d world_from_view = view_from_world_.inverse();
  const Eigen::Vector3d at((point.x - middle_.x()) / focal_.x(),
                           (point.y - middle_.y()) / focal_.y(), parallel_ ? 0 : 1);
  if (parallel_) return {world_from_view * at, world_from_view.linear().col(2)};
  return {world_from_view.translation(), (world_from_view.linear() * at).normalized()};
}

void Tape::Add(const Eigen::Vector3d& point_in_world) {
  if (points.size() == 2) points.clear();
  points.push_back(point_in_world);
}

std::string TapeReading(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& up_in_world) {
  const double up_m = (b - a).dot(up_in_world);
  const double across_m = (b - a - up_m * up_in_world).norm();
  return fmt::format("{:.3f} m\n{:.3f} across, {:.3f} {}", (b - a).norm(), across_m, std::abs(up_m),
                     up_m < 0 ? "down" : "up");
}

void DrawTape(const FrameContext& context, const SceneProjection& project, ImVec2 low, ImVec2 high,
              const Tape& tape) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect(low, high, true);
  std::vector<ImVec2> ends;
  for (const Eigen::Vector3d& point : tape.points) {
    if (const auto at = project(point)) ends.push_back(*at);
  }
  const bool whole = ends.size() == 2;
  if (whole) {
    draw.AddLine(ends[0], ends[1], IM_COL32(0, 0, 0, 160), context.Scaled(4));
    draw.AddLine(ends[0], ends[1], colors::kOnPicture, context.Scaled(2));
  }
  for (const ImVec2& end : ends) {
    draw.AddCircleFilled(end, context.Scaled(4.5f), IM_COL32(0, 0, 0, 160));
    draw.AddCircleFilled(end, context.Scaled(3), colors::kOnPicture);
  }
  PictureLabels labels(context, low, high);
  const std::string text =
      whole ? TapeReading(tape.points[0], tape.points[1], context.sequence->up_in_world)
      : tape.points.empty() ? "Click two points."
                            : "Click the other point.";
  const ImVec2 size = labels.SizeOf(text);
  const ImVec2 middle = whole
                            ? ImVec2(0.5f * (ends[0].x + ends[1].x), 0.5f * (ends[0].y + ends[1].y))
                            : ImVec2(0.5f * (low.x + high.x), low.y + 2 * size.y);
  const float x = middle.x - 0.5f * size.x;
  labels.Add({{x, middle.y - context.Scaled(10)}, {x, middle.y + 1.5f * size.y}},
             colors::kOnPicture, text);
  draw.PopClipRect();
}

void DrawSceneOverlay(const FrameContext& context, const SceneProjection& project, ImVec2 low,
                      ImVec2 high, const SceneOverlay& overlay,
                      const std::vector<ObjectRelation>& relations) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect(low, high, true);
  if (context.sequence->own_poses != nullptr) {
    if (overlay.points) DrawPoints(context, project, overlay.clip);
    if (overlay.spread) DrawCameraSpread(context, project);
  }
  std::map<ObjectId, ImVec2> centers;
  for (const ObjectReport& object : context.snapshot->report.objects) {
    const bool shown =
        object.state == ObjectState::kConfirmed || object.id == context.selection.object;
    if (!shown || (overlay.clip && !overlay.clip->Holds(CenterOf(context, object)))) continue;
    if (overlay.spread)
      DrawSpread(context, project, CenterOf(context, object),
                 object.covariance.topLeftCorner<3, 3>(), kBelief95, context.ColorOf(object.id));
    if (const auto at = project(CenterOf(context, object))) centers[object.id] = *at;
  }
  PictureLabels labels(context, low, high);
  if (overlay.links) {
    for (const ObjectRelation& relation : relations) {
      if (!centers.contains(relation.a) || !centers.contains(relation.b)) continue;
      const ImVec2 a = centers[relation.a], b = centers[relation.b];
      draw.AddLine(a, b, IM_COL32(0, 0, 0, 120), context.Scaled(4));
      draw.AddLine(a, b, LinkColor(relation.kind), context.Scaled(2));
      draw.AddCircleFilled(b, context.Scaled(4), LinkColor(relation.kind));
    }
  }
  if (overlay.names) {
    for (const ObjectReport& object : context.snapshot->report.objects) {
      const auto at = centers.find(object.id);
      if (at == centers.end()) continue;
      const ModelView* model = context.Model(object.label);
      const std::string text =
          fmt::format("#{} {}", object.id.value, model != nullptr ? model->name : object.category);
      const ImVec2 size = labels.SizeOf(text);
      const ImVec2 c = at->second;
      if (c.x < low.x || c.x > high.x || c.y < low.y || c.y > high.y) continue;
      const float x = c.x - 0.5f * size.x, y = c.y + 0.5f * size.y, step = 1.15f * size.y;
      labels.Add({{x, y},
                  {x, y - step},
                  {x, y + step},
                  {x, y - 2 * step},
                  {x, y + 2 * step},
                  {c.x, y - 3 * step}},
                 context.ColorOf(object.id), text,
                 object.id == context.selection.object ? PictureLabels::Need::kAlways
                                                       : PictureLabels::Need::kIfFree);
    }
  }
  DrawTruths(context, project, overlay, low, high, labels);
  draw.PopClipRect();
}

std::string TruthNear(const FrameContext& context, const SceneProjection& project, ImVec2 point) {
  std::string nearest;
  float nearest_px = context.Scaled(14);
  for (const SequenceView::Truth& truth : context.sequence->truth) {
    const auto at = project(MiddleOf(context, truth));
    if (!at) continue;
    const float distance = std::hypot(at->x - point.x, at->y - point.y);
    if (distance >= nearest_px) continue;
    nearest_px = distance;
    nearest = truth.id;
  }
  return nearest;
}

}  // namespace plumbline
