// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_actions.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "ui/annotate/annotate_crop_box.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/framework/annotate_view.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

// labelCloud's keys for moving, with finer steps; Shift is coarse.
constexpr double kFine_m = 0.005, kCoarse_m = 0.05;
constexpr double kFine_rad = 0.5 * std::numbers::pi / 180, kCoarse_rad = 5 * std::numbers::pi / 180;

/// One of the six floor directions and turns, for each nudge key.
struct Nudge {
  int key;
  double right, ahead, up, turn;
};
constexpr Nudge kNudges[] = {{keys::kW, 0, 1, 0, 0},  {keys::kS, 0, -1, 0, 0},
                             {keys::kA, -1, 0, 0, 0}, {keys::kD, 1, 0, 0, 0},
                             {keys::kE, 0, 0, 1, 0},  {keys::kQ, 0, 0, -1, 0},
                             {keys::kZ, 0, 0, 0, 1},  {keys::kX, 0, 0, 0, -1}};

bool Editable(const FrameContext& context, const AnnotatedInstance* instance) {
  return instance != nullptr && !instance->locked && !context.annotation->read_only;
}

/// What the nudge keys of this frame ask for, as the view is turned: metres in the level frame, and
/// a turn. True while one of them is down.
bool ReadNudges(const FrameContext& context,
                const std::function<void(const Vector3d& by, double turn_rad)>& nudge_by) {
  const ImGuiIO& io = ImGui::GetIO();
  const Eigen::Matrix3d eye = context.annotate_scene->camera().view_from_world;
  Vector3d right = eye.row(0).transpose();
  right.z() = 0;
  right.normalize();
  const Vector3d ahead = Vector3d::UnitZ().cross(right);
  bool any_down = false;
  for (const Nudge& nudge : kNudges) {
    any_down = any_down || ImGui::IsKeyDown(nudge.key);
    if (io.KeyCtrl || !ImGui::IsKeyPressed(nudge.key, true)) continue;
    const double step = io.KeyShift ? kCoarse_m : kFine_m;
    nudge_by(step * (nudge.right * right + nudge.ahead * ahead + nudge.up * Vector3d::UnitZ()),
             nudge.turn * (io.KeyShift ? kCoarse_rad : kFine_rad));
  }
  return any_down;
}

void NudgeBox(const FrameContext& context, LevelBox& box) {
  ReadNudges(context, [&](const Vector3d& by, double turn_rad) {
    box.center += by;
    box.azimuth_rad = WrapAngle(box.azimuth_rad + turn_rad);
  });
}

void PostNudges(const FrameContext& context, const AnnotatedInstance& instance, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  AnnotateView& view = *context.annotate;
  const bool any_down = ReadNudges(context, [&](const Vector3d& by, double turn_rad) {
    const bool moving = view.pending && view.pending->id == instance.id;
    Eigen::Isometry3d pose = moving ? view.pending->scan_from_object : instance.scan_from_object;
    pose = Moved(snapshot, pose, by);
    if (turn_rad != 0) pose = Turned(snapshot, pose, Vector3d::UnitZ(), turn_rad);
    view.pending = PendingPose{instance.id, pose, std::nullopt};
    view.nudged = true;
  });
  if (any_down || !view.nudged) return;
  view.nudged = false;
  if (view.pending) {
    sink.Post(SetInstancePoseCommand{view.pending->id, view.pending->scan_from_object});
  }
}

/// Keys that answer a proposal; true if there is one.
bool PostAnswer(const FrameContext& context, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  AnnotateView& view = *context.annotate;
  if (ImGui::IsKeyPressed(keys::kEscape, false)) {
    if (view.tool == AnnotateTool::kCut && (!view.lasso.empty() || view.crop_box)) {
      DropCut(context, sink);
    } else if (snapshot.HasProposal()) {
      sink.Post(CancelProposalCommand{});
    } else if (view.tool != AnnotateTool::kSelect) {
      view.tool = AnnotateTool::kSelect;
    } else {
      sink.Post(SelectInstanceCommand{});
    }
    return true;
  }
  const bool cut_now = view.crop_by_line ? !view.lasso_closed : !snapshot.crop;
  if (view.tool == AnnotateTool::kCut && cut_now && ImGui::IsKeyPressed(keys::kEnter, false)) {
    ProposeCrop(context, sink);
    return true;
  }
  if (view.tool == AnnotateTool::kCut && view.crop_box) NudgeBox(context, *view.crop_box);
  if (!snapshot.HasProposal()) return false;
  if (ImGui::IsKeyPressed(keys::kEnter, false)) {
    if (snapshot.floor) {
      view.tool = AnnotateTool::kSelect;
      view.reset = true;
    }
    const auto ready = [](const auto& proposal) {
      return proposal && !proposal->running && proposal->problem.empty();
    };
    if (ready(snapshot.sequence_alignment) || ready(snapshot.crop))
      view.tool = AnnotateTool::kSelect;
    AcceptProposal(context, view.candidate, sink);
  }
  if (snapshot.placement) {
    const int count = static_cast<int>(snapshot.placement->candidates.size());
    if (ImGui::IsKeyPressed(keys::kDown)) view.candidate = std::min(view.candidate + 1, count - 1);
    if (ImGui::IsKeyPressed(keys::kUp)) view.candidate = std::max(view.candidate - 1, 0);
  }
  return true;
}

void PostControlKeys(const FrameContext& context, const AnnotatedInstance* instance,
                     CommandSink& sink) {
  const ImGuiIO& io = ImGui::GetIO();
  AnnotateView& view = *context.annotate;
  const auto pressed = [](int key) { return ImGui::IsKeyPressed(key, false); };
  if (pressed(keys::kZ)) {
    if (io.KeyShift) {
      sink.Post(RedoCommand{});
    } else {
      sink.Post(UndoCommand{});
    }
  }
  if (pressed(keys::kY)) sink.Post(RedoCommand{});
  if (pressed(keys::kS)) sink.Post(SaveProjectCommand{});
  if (instance == nullptr) return;
  if (pressed(keys::kC)) view.copied = instance->scan_from_object;
  if (pressed(keys::kV) && view.copied && Editable(context, instance))
    sink.Post(SetInstancePoseCommand{instance->id, *view.copied});
  if (pressed(keys::kD)) Duplicate(context, sink);
}

}  // namespace

std::vector<ActionGroup> AnnotateActions() {
  const auto watched = [](std::vector<KeyStroke> strokes, const char* help_keys, const char* help) {
    return Action{.keys = std::move(strokes), .help_keys = help_keys, .help = help};
  };
  return {
      {"Move",
       {watched({{keys::kW},
                 {keys::kA},
                 {keys::kS},
                 {keys::kD},
                 {keys::kW, true},
                 {keys::kA, true},
                 {keys::kS, true},
                 {keys::kD, true}},
                "W A S D", "Move it along the floor by 5 mm (Shift: 5 cm)"),
        watched({{keys::kQ}, {keys::kE}, {keys::kQ, true}, {keys::kE, true}}, "Q  E",
                "Lower or raise it by 5 mm (Shift: 5 cm)"),
        watched({{keys::kZ}, {keys::kX}, {keys::kZ, true}, {keys::kX, true}}, "Z  X",
                "Turn it by 0.5\u00b0 (Shift: 5\u00b0)"),
        watched({{keys::kG}}, "G", "Onto the floor")}},
      {"Align",
       {watched({{keys::kI}, {keys::kI, true}}, "I",
                "Refine: align it to the scan (Shift: to the images)"),
        watched({{keys::kT}}, "T", "Try all azimuths"),
        watched({{keys::kEnter}, {keys::kEscape}}, "Enter  Esc", "Accept or discard the proposal"),
        watched({{keys::kUp}, {keys::kDown}}, "\u2191  \u2193", "Previous or next candidate")}},
      {"Edit",
       {watched({{keys::kH}, {keys::kL}}, "H  L", "Hide, lock it"),
        watched({{keys::kDelete}}, "Del", "Remove it"),
        watched({{keys::kD, false, true}}, "Ctrl + D", "Duplicate it"),
        watched({{keys::kC, false, true}, {keys::kV, false, true}}, "Ctrl + C  V",
                "Copy, paste the pose"),
        watched({{keys::kZ, false, true}, {keys::kY, false, true}, {keys::kZ, true, true}},
                "Ctrl + Z  Y", "Undo, redo"),
        watched({{keys::kS, false, true}}, "Ctrl + S", "Save")}}};
}

void NotePosted(const AnnotationCommand& command, std::optional<std::uint64_t> number,
                AnnotateView& view) {
  const auto* pose = std::get_if<SetInstancePoseCommand>(&command);
  if (pose == nullptr || !view.pending || view.pending->id != pose->id) return;
  view.pending->command = number;
  if (!number) view.pending.reset();
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
  sink.Post(CancelProposalCommand{});
}

void Duplicate(const FrameContext& context, CommandSink& sink) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  const AnnotatedInstance* instance = snapshot.Selected();
  if (instance == nullptr) return;
  const AnnotationModel* model = snapshot.ModelOf(*instance);
  const double beside = model != nullptr ? 1.1 * model->bounds.sizes().head<2>().maxCoeff() : 0.5;
  sink.Post(DuplicateInstanceCommand{instance->id,
                                     Moved(snapshot, instance->scan_from_object, {beside, 0, 0})});
}

void PostAnnotateShortcuts(const FrameContext& context, CommandSink& sink) {
  if (context.annotation == nullptr || context.annotate_scene == nullptr) return;
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput || ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopupId)) return;
  const AnnotatedInstance* instance = context.annotation->Selected();
  if (io.KeyCtrl) return PostControlKeys(context, instance, sink);
  if (PostAnswer(context, sink)) return;
  if (instance == nullptr || context.annotate->tool == AnnotateTool::kCut) return;
  if (Editable(context, instance)) {
    PostNudges(context, *instance, sink);
    const auto pressed = [](int key) { return ImGui::IsKeyPressed(key, false); };
    if (pressed(keys::kG)) {
      const LevelPose pose = ReadPose(*context.annotation, instance->scan_from_object);
      sink.Post(SetInstancePoseCommand{
          instance->id, Moved(*context.annotation, instance->scan_from_object, {0, 0, -pose.z})});
    }
    if (pressed(keys::kI) && io.KeyShift) {
      sink.Post(RefineByImagesCommand{instance->id, context.annotate->on_floor});
    } else if (pressed(keys::kI)) {
      sink.Post(RefineInstanceCommand{instance->id, context.annotate->on_floor});
    }
    if (pressed(keys::kT)) PlaceAgain(context, sink);
    if (pressed(keys::kDelete)) sink.Post(RemoveInstanceCommand{instance->id});
  }
  ChangeInstanceCommand change;
  change.id = instance->id;
  if (ImGui::IsKeyPressed(keys::kH, false)) {
    change.set.hidden = !instance->hidden;
    sink.Post(change);
  } else if (ImGui::IsKeyPressed(keys::kL, false)) {
    change.set.locked = !instance->locked;
    sink.Post(change);
  }
}

}  // namespace plumbline
