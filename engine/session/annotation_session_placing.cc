// SPDX-License-Identifier: Apache-2.0
// The part of the session that proposes: floors, places for models, refinements.
#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/geometry/gravity.h"
#include "engine/session/annotation_session.h"

namespace plumbline {

void AnnotationSession::DropProposals() {
  view_.floor.reset();
  view_.placement.reset();
  view_.refinement.reset();
  view_.sequence_alignment.reset();
  view_.crop.reset();
  view_.checklist.comparing = false;
  prepared_crop_.reset();
  ++view_.proposal_number;
  ++proposals_;
  std::erase_if(jobs_, [](const Job& job) { return job.can_cancel; });
  cancel_ = true;
}

/// Runs before everything that waits; its updates count only while nothing else is proposed.
void AnnotationSession::Propose(Job job) {
  job.can_cancel = true;
  const std::uint64_t number = proposals_;
  const auto guarded = [number](Update update) -> Update {
    return [number, update = std::move(update)](AnnotationSession& session) {
      if (session.proposals_ != number) return;
      update(session);
      ++session.view_.proposal_number;
    };
  };
  job.run = [guarded, run = std::move(job.run)](const WorkContext& work,
                                                const std::function<void(Update)>& emit) -> Update {
    return guarded(run(work, [&](Update update) { emit(guarded(std::move(update))); }));
  };
  jobs_.push_front(std::move(job));
}

FloorHints AnnotationSession::Hints() const {
  FloorHints hints;
  hints.camera_centers = CamerasInScan();
  return hints;
}

void AnnotationSession::On(const FindFloorCommand& command) {
  if (scan_.target == nullptr) return Refuse("The scan is still being prepared.");
  DropProposals();
  Propose({"Looking for the floor", true,
           [target = scan_.target, seed = command.seed_in_scan, hints = Hints(), up = up_in_scan()](
               const WorkContext&, const auto&) -> Update {
             auto floor = ProposeFloor(*target, seed, hints, up);
             return [floor](AnnotationSession& session) {
               if (!floor) return session.Refuse(floor.error().message);
               session.view_.floor = *floor;
             };
           }});
}

void AnnotationSession::On(const TypeGravityCommand& command) {
  if (!(command.up_in_scan.norm() > 1e-6)) return Refuse("Up needs a length: type three numbers.");
  DropProposals();
  FloorProposal proposal;
  proposal.source = "typed";
  proposal.up_in_scan = command.up_in_scan.normalized();
  proposal.offset_m = command.floor_offset_m;
  proposal.turn_rad = std::acos(std::clamp(proposal.up_in_scan.dot(up_in_scan()), -1.0, 1.0));
  if (scan_.target != nullptr) {
    ShowFloorPoints(*scan_.target, proposal);
    proposal.num_inliers = proposal.inliers->size();
  }
  view_.floor = std::move(proposal);
}

/// Nothing, with an answer, if it cannot be done now.
std::optional<PlacementTask> AnnotationSession::TaskFor(int model, const Eigen::Isometry3d& pose,
                                                        bool on_floor, double scale) {
  const AnnotationModel* view = view_.Model(model);
  if (view == nullptr) {
    Refuse("The database has no such model.");
    return std::nullopt;
  }
  if (scan_.target == nullptr) {
    Refuse(view_.scan_name.empty() ? "There is no scan to align to."
                                   : "The scan is still being prepared.");
    return std::nullopt;
  }
  if (surfaces_[model] == nullptr) {
    auto surface = ModelSurface::Prepare(*view->mesh);
    if (!surface) {
      Refuse(view->name + ": " + surface.error().message);
      return std::nullopt;
    }
    surfaces_[model] = std::move(*surface);
  }
  PlacementTask task;
  task.target = scan_.target;
  task.scan = scan_.full;
  task.surface = surfaces_[model];
  task.mesh = view->mesh;
  task.unscaled = task.surface;
  task.unscaled_mesh = task.mesh;
  if (scale != 1) {
    task.scale = scale;
    task.mesh = std::make_shared<const TriangleMesh>(Scaled(TriangleMesh(*view->mesh), scale));
    task.surface = *ModelSurface::Prepare(*task.mesh);  // as good as the unscaled one
  }
  task.scan_from_object = pose;
  task.up_in_scan = up_in_scan();
  task.stands = on_floor && view->on_floor;
  if (task.stands) task.floor_in_scan = project_->document().floor_in_scan;
  return task;
}

void AnnotationSession::QueuePlacement(PlacementTask task, int model, std::string instance) {
  DropProposals();
  PlacementView placement;
  placement.asked_by = command_;
  placement.model = model;
  placement.instance = std::move(instance);
  placement.scale = task.scale;
  view_.placement = placement;
  std::optional<PlacementQuestion> images;
  if (sequence_ != nullptr && outlines_ != nullptr) {
    images = PlacementQuestion{
        sequence_,
        outlines_,
        project_->document(),
        view_.Model(model)->name,
        placement.instance,
        task.up_in_scan,
        task.floor_in_scan ? FreeMotion::kAzimuthAndHorizontal : FreeMotion::kAzimuthAndTranslation,
        task.scale};
  }
  Propose({"Trying 24 azimuths", true,
           [task = std::move(task), images = std::move(images), placement](
               const WorkContext& work, const auto& emit) -> Update {
             PlacementView found = placement;
             FindPlacements(task, work, found);
             const auto show = [&](const PlacementView& now) {
               emit([now](AnnotationSession& session) { session.view_.placement = now; });
             };
             if (images) {
               show(found);  // nobody waits for the images
               const auto chosen = [&](const PlacementImages& frames) {
                 emit([frames, question = *images,
                       asked_by = placement.asked_by](AnnotationSession& session) {
                   session.TakeImages(question, asked_by, frames);
                 });
               };
               ComparePlacements(*images, task.scan_from_object, work, chosen, show, found);
               AddPictures(task, found);
             }
             return [found](AnnotationSession& session) { session.view_.placement = found; };
           }});
}

void AnnotationSession::On(const PlaceModelCommand& command) {
  const auto id = models_ != nullptr ? models_->Find(command.model) : std::nullopt;
  const int model = id ? id->value : -1;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = UprightFrame(-up_in_scan()).upright_rotation();
  pose.translation() = command.point_in_scan;
  auto task = TaskFor(model, pose, command.on_floor);
  if (!task) return;
  if (const auto& floor = task->floor_in_scan) {  // a click on the seat means what is below it
    const Eigen::Vector3d up = floor->head<3>();
    task->scan_from_object.translation() -= up * (up.dot(command.point_in_scan) + (*floor)[3]);
  }
  task->view_azimuth_rad = command.view_azimuth_rad;
  QueuePlacement(std::move(*task), model, "");
}

void AnnotationSession::On(const PlaceAgainCommand& command) {
  const AnnotatedInstance* instance = project_->document().Find(command.id);
  if (instance == nullptr || models_ == nullptr) return Refuse("Select an object first.");
  if (instance->locked) return Refuse("'" + command.id + "' is locked; unlock it first.");
  const auto id = models_->Find(instance->model);
  auto task =
      TaskFor(id ? id->value : -1, instance->scan_from_object, command.on_floor, instance->scale);
  if (!task) return;
  task->view_azimuth_rad = command.view_azimuth_rad;
  QueuePlacement(std::move(*task), id->value, command.id);
}

void AnnotationSession::On(const AcceptProposalCommand& command) {
  if (const auto& floor = view_.floor) {
    SetGravity edit{-floor->up_in_scan, std::nullopt};
    if (floor->offset_m) {
      edit.floor_in_scan = Eigen::Vector4d(floor->up_in_scan.x(), floor->up_in_scan.y(),
                                           floor->up_in_scan.z(), *floor->offset_m);
    }
    if (!Edit(edit)) return;
    view_.gravity_known = true;
  } else if (const auto& placement = view_.placement) {
    if (placement->running || placement->candidates.empty()) return;
    const auto chosen = std::find_if(
        placement->candidates.begin(), placement->candidates.end(),
        [&](const auto& found) { return !command.candidate || found.id == *command.candidate; });
    if (chosen == placement->candidates.end()) return Refuse("There is no such candidate.");
    const Eigen::Isometry3d pose = chosen->scan_from_object;
    if (placement->instance.empty()) {
      const AnnotationModel& model = *view_.Model(placement->model);
      AnnotatedInstance instance;
      instance.id = project_->document().FreeId(model.name);
      instance.model = model.name;
      instance.category = model.category;
      instance.scan_from_object = pose;
      instance.annotator = view_.annotator;
      instance.fine = placement->problem.empty();
      instance.seconds_spent = work_time_.ToWrite(WorkTime::kNext);
      if (!Edit(AddInstance{instance, std::nullopt})) return;
      work_time_.Forget(WorkTime::kNext);
      view_.selected = instance.id;
    } else {
      On(SetInstancePoseCommand{placement->instance, pose});
    }
  } else if (view_.refinement) {
    if (!TakeRefinement()) return;
  } else if (const auto& alignment = view_.sequence_alignment) {
    if (alignment->running || !alignment->problem.empty()) return;
    if (!Edit(SetSceneAlignment{alignment->scan_from_world})) return;
  } else if (view_.crop) {
    if (!TakeCrop()) return;
  } else {
    return;
  }
  DropProposals();
}

bool AnnotationSession::TakeRefinement() {
  ChangeInstance edit;
  edit.id = view_.refinement->instance;
  edit.set.scan_from_object = view_.refinement->scan_from_object;
  if (view_.refinement->scale_std > 0) edit.set.scale = view_.refinement->scale;
  work_time_.GiveNextTo(edit.id);
  return Edit(edit);
}

void AnnotationSession::On(const CancelProposalCommand&) { DropProposals(); }

}  // namespace plumbline
