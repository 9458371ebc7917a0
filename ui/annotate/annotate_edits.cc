// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_edits.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ui/annotate/annotate_crop_box.h"
#include "ui/annotate/annotate_pose.h"

namespace plumbline {

using Eigen::Vector3d;

namespace {

/// The selected ones that may be moved, but for one.
std::vector<const AnnotatedInstance*> OthersToMove(const FrameContext& context,
                                                   const std::string& but) {
  std::vector<const AnnotatedInstance*> others;
  for (const std::string& id : SelectedInstances(context)) {
    const AnnotatedInstance* instance = context.annotation->Find(id);
    if (id != but && instance != nullptr && !instance->locked) others.push_back(instance);
  }
  return others;
}

}  // namespace

std::optional<Eigen::Vector3d> PlaceAt(const FrameContext& context, double x_px, double y_px) {
  AnnotateSurface& scene = *context.annotate_scene;
  if (const auto point = scene.PickScan(x_px, y_px)) return point;
  const SightLine sight = scene.Sight(x_px, y_px);
  if (!context.annotation->floor_known || sight.direction.z() > -0.05) return std::nullopt;
  return Eigen::Vector3d(sight.eye - sight.eye.z() / sight.direction.z() * sight.direction);
}

void PlaceChosenModel(const FrameContext& context, double x_px, double y_px, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  const auto point = PlaceAt(context, x_px, y_px);
  if (!point || view.model.empty()) return;
  view.candidate = 0;
  sink.Post(PlaceModelCommand{view.model, context.annotation->level_from_scan.inverse() * *point,
                              context.annotate_scene->camera().azimuth_rad, view.on_floor});
}

void ChooseModel(const FrameContext& context, const std::string& model, CommandSink& sink) {
  context.annotate->model = model;
  context.annotate->tool = AnnotateTool::kPlace;
  sink.Post(CancelProposalCommand{});
}

void NotePosted(const AnnotationCommand& command, std::optional<std::uint64_t> number,
                AnnotateView& view) {
  const auto* pose = std::get_if<SetInstancePoseCommand>(&command);
  if (pose == nullptr || !view.pending || view.pending->id != pose->id) return;
  view.pending->command = number;
  if (!number) view.pending.reset();
}

PendingPose OnItsWay(const FrameContext& context, const AnnotatedInstance& instance,
                     const Eigen::Isometry3d& scan_from_object) {
  constexpr double kTilted = 1e-9;  // 1 - cosine of 2.6 thousandths of a degree
  PendingPose pending{instance.id, scan_from_object, std::nullopt};
  const Eigen::Isometry3d moved = scan_from_object * instance.scan_from_object.inverse();
  const Vector3d up = UpInScan(*context.annotation);
  if (1 - up.dot(moved.linear() * up) > kTilted) return pending;
  for (const AnnotatedInstance* other : OthersToMove(context, instance.id))
    pending.and_also.push_back({other->id, moved * other->scan_from_object});
  return pending;
}

SetInstancePoseCommand EditOf(const PendingPose& pending) {
  return {pending.id, pending.scan_from_object, pending.and_also};
}

void PutOntoFloor(const FrameContext& context, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  const auto on_floor = [&](const AnnotatedInstance& instance) {
    const double height_m = ReadPose(snapshot, instance.scan_from_object).z;
    return Moved(snapshot, instance.scan_from_object, {0, 0, -height_m});
  };
  const AnnotatedInstance& first = *snapshot.Selected();
  SetInstancePoseCommand edit{first.id, on_floor(first)};
  for (const AnnotatedInstance* other : OthersToMove(context, first.id))
    edit.and_also.push_back({other->id, on_floor(*other)});
  sink.Post(edit);
}

void FollowSnapshot(const AnnotationSnapshot& before, const AnnotationSnapshot& now,
                    AnnotateView& view) {
  const bool same_placement =
      before.placement && now.placement && before.placement->asked_by == now.placement->asked_by;
  if (!same_placement) {
    view.candidate = 0;
  } else if (view.candidate > 0) {
    const auto& old = before.placement->candidates;
    const auto& candidates = now.placement->candidates;
    const auto chosen = static_cast<std::size_t>(view.candidate);
    for (std::size_t i = 0; chosen < old.size() && i < candidates.size(); ++i) {
      if (candidates[i].id == old[chosen].id) view.candidate = static_cast<int>(i);
    }
  }
  if (before.selected != now.selected) {
    view.also_selected.clear();
    if (!view.select_also.empty() && view.select_also.front() == now.selected)
      view.also_selected.assign(view.select_also.begin() + 1, view.select_also.end());
    view.select_also.clear();
    if (std::exchange(view.select_copies, false)) {
      for (const AnnotatedInstance& instance : now.instances) {
        if (before.Find(instance.id) == nullptr && instance.id != now.selected)
          view.also_selected.push_back(instance.id);
      }
    }
  }
  if (now.fitted_box && now.fitted_box != before.fitted_box &&
      std::exchange(view.awaits_box, false)) {
    if (now.fitted_box->box && view.crop_box && view.tool == AnnotateTool::kCut)
      view.crop_box = InLevel(now, *now.fitted_box->box);
  }
  std::erase_if(view.also_selected, [&](const std::string& id) { return now.Find(id) == nullptr; });
  if (!view.pending) return;
  const auto& command = view.pending->command;
  const bool done = command && now.last_command.number >= *command;
  if (done || now.Find(view.pending->id) == nullptr) view.pending.reset();
}

void AcceptProposal(const FrameContext& context, int candidate, CommandSink& sink) {
  AcceptProposalCommand command;
  const auto& placement = context.annotation->placement;
  if (placement && candidate >= 0 && candidate < static_cast<int>(placement->candidates.size())) {
    command.candidate = placement->candidates[static_cast<std::size_t>(candidate)].id;
  }
  sink.Post(command);
}

void PlaceAgain(const FrameContext& context, CommandSink& sink) {
  const AnnotatedInstance* instance = context.annotation->Selected();
  if (instance == nullptr) return;
  context.annotate->candidate = 0;
  sink.Post(PlaceAgainCommand{instance->id, context.annotate_scene->camera().azimuth_rad,
                              context.annotate->on_floor});
}

void ProposeCrop(const FrameContext& context, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  if (view.crop_box) {
    ProposeCropCommand command{view.crop_id, view.crop_category, view.crop_fragment};
    command.box = InScan(*context.annotation, *view.crop_box);
    return sink.Post(command);
  }
  if (view.lasso.size() < 3) return;
  view.lasso_closed = true;
  const AnnotateSurface& scene = *context.annotate_scene;
  const SceneCamera camera = scene.camera();
  Eigen::Isometry3d level_from_cam = Eigen::Isometry3d::Identity();
  const Vector3d flip(1, -1, -1);  // x right, y down, z ahead
  level_from_cam.linear() = (flip.asDiagonal() * camera.view_from_world).transpose();
  level_from_cam.translation() = scene.Sight(0, 0).eye;
  ProposeCropCommand command{view.crop_id, view.crop_category, view.crop_fragment};
  command.polygon_px = view.lasso;
  command.scan_from_cam = context.annotation->level_from_scan.inverse() * level_from_cam;
  command.focal_px = 0.5 * view.view_px.y() / std::tan(0.5 * camera.view_angle_rad);
  command.center_px = 0.5 * view.view_px - Eigen::Vector2d(0.5, 0.5);
  sink.Post(command);
}

void DropCut(const FrameContext& context, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  view.lasso.clear();
  view.lasso_closed = false;
  view.crop_box.reset();
  view.awaits_box = false;
  sink.Post(CancelProposalCommand{});
}

void Duplicate(const FrameContext& context, CommandSink& sink) {
  if (context.annotation->Selected() == nullptr) return;
  AnnotateView& view = *context.annotate;
  view.select_copies = !view.also_selected.empty();
  sink.Post(DuplicateInstanceCommand{context.annotation->selected, view.also_selected});
}

std::vector<std::string> SelectedInstances(const FrameContext& context) {
  if (context.annotation->Selected() == nullptr) return {};
  std::vector<std::string> ids = context.annotate->also_selected;
  ids.insert(ids.begin(), context.annotation->selected);
  return ids;
}

void SelectInstances(const FrameContext& context, std::vector<std::string> ids, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  view.also_selected.clear();
  view.select_also.clear();
  if (ids.empty()) return sink.Post(SelectInstanceCommand{});
  if (ids.front() == context.annotation->selected) {
    view.also_selected.assign(ids.begin() + 1, ids.end());
    return;
  }
  sink.Post(SelectInstanceCommand{ids.front()});
  view.select_also = std::move(ids);
}

void ToggleSelected(const FrameContext& context, const std::string& id, CommandSink& sink) {
  std::vector<std::string> ids = SelectedInstances(context);
  if (std::erase(ids, id) == 0) ids.push_back(id);
  SelectInstances(context, std::move(ids), sink);
}

void CopyInstance(const FrameContext& context, const AnnotatedInstance& instance) {
  context.annotate->copied = instance.scan_from_object;
  context.annotate->copied_id = instance.id;
}
}  // namespace plumbline
