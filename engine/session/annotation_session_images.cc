// SPDX-License-Identifier: Apache-2.0
// The part of the session that looks at the images of the sequence.
#include "engine/session/annotation_session.h"

#include <utility>

namespace plumbline {

void AnnotationSession::QueueOutlines() {
  if (sequence_ == nullptr || models_ == nullptr) return;
  jobs_.push_back(
      {"Preparing the outlines", false,
       [scan = scan_.full, models = models_](const WorkContext&, const auto&) -> Update {
         std::shared_ptr<const OccludingScan> hides;
         if (scan != nullptr) {
           if (auto prepared = OccludingScan::Prepare(scan)) hides = *prepared;
         }
         auto outlines = std::make_shared<OutlineScene>(models, hides);
         return [outlines](AnnotationSession& session) {
           session.outlines_ = outlines;
           session.WantChecks();
         };
       }});
}

void AnnotationSession::WantChecks() {
  if (outlines_ == nullptr) return;
  const auto& placement = view_.placement;
  if (placement && !placement->candidates.empty()) {
    // Their key frames come with the comparison of the candidates.
    images_wanted_ = false;
    const bool known = images_ != nullptr && images_->placement == placement->asked_by;
    if (!known) view_.checks = ImageChecksView{placement->instance};
    check_wanted_ = known && (!checked_ || checked_->matrix() != JudgedPoseNow().matrix());
    return;
  }
  const AnnotatedInstance* selected = project_->document().Find(view_.selected);
  if (selected == nullptr) {
    view_.checks.reset();
    images_wanted_ = check_wanted_ = false;
    return;
  }
  const bool other =
      images_ == nullptr || images_->placement > 0 || images_->instance != selected->id;
  if (other || (!preview_ && !images_->Suit(project_->document(), *selected))) {
    if (!view_.checks || view_.checks->instance != selected->id) {
      view_.checks = ImageChecksView{selected->id};
    }
    images_wanted_ = true;
    check_wanted_ = false;
  } else {
    images_wanted_ = false;
    if (!checked_ || checked_->matrix() != JudgedPoseNow().matrix()) check_wanted_ = true;
  }
}

/// That the images are to show: of a candidate, a proposal, a drag, or where the object is placed.
Eigen::Isometry3d AnnotationSession::JudgedPoseNow() const {
  if (preview_) return *preview_;
  const auto& placement = view_.placement;
  if (placement && !placement->candidates.empty()) {
    return placement->candidates.front().scan_from_object;
  }
  return PoseOf(view_.selected);
}

/// Where the object is placed, if that is not what is judged, and what contradicts a refinement.
std::vector<ComparedPose> AnnotationSession::ComparedPoses() const {
  std::vector<ComparedPose> compared;
  const std::string& id = view_.placement ? view_.placement->instance : view_.selected;
  const Eigen::Isometry3d judged = JudgedPoseNow();
  const AnnotatedInstance* placed = project_->document().Find(id);
  if (placed != nullptr && placed->scan_from_object.matrix() != judged.matrix()) {
    compared.push_back({std::nullopt, placed->scan_from_object});
  }
  if (!view_.refinement || !view_.refinement->contradict) return compared;
  for (const RefinedPose& found : view_.refinement->found) {
    if (found.by == RefineBy::kBoth || found.by == view_.refinement->by) continue;
    compared.push_back({found.by, found.scan_from_object});
  }
  return compared;
}

AnnotationSession::Job AnnotationSession::ImagesJob() {
  const std::string id = view_.selected;
  return {"Choosing key frames of " + id, true,
          [id, sequence = sequence_, document = project_->document(), outlines = outlines_](
              const WorkContext& work, const auto&) -> Update {
            auto read = ReadInstanceImages(sequence, document, id, *outlines, work);
            return [read, id](AnnotationSession& session) {
              if (!read && read.error().code == ErrorCode::kCancelled) return session.WantChecks();
              if (session.view_.selected != id) return session.WantChecks();
              session.images_ = std::make_shared<const InstanceImages>(
                  read ? *read : InstanceImages::None(session.project_->document(), id));
              ++session.view_.images_number;
              session.checked_.reset();
              session.WantChecks();
              if (!read) session.Refuse(read.error().message);
            };
          }};
}

AnnotationSession::Job AnnotationSession::CheckJob() {
  const Eigen::Isometry3d pose = JudgedPoseNow();
  checked_ = pose;
  return {"", false,
          [images = images_, outlines = outlines_, document = project_->document(), pose,
           others = ComparedPoses()](const WorkContext&, const auto&) -> Update {
            auto view =
                CheckPose(*images, pose, others, outlines->OccludersOf(document, images->instance));
            return [view = std::move(view), images](AnnotationSession& session) {
              if (session.images_ == images) session.view_.checks = view;
            };
          }};
}

Eigen::Isometry3d AnnotationSession::PoseOf(const std::string& id) const {
  const AnnotatedInstance* instance = project_->document().Find(id);
  return instance != nullptr ? instance->scan_from_object : Eigen::Isometry3d::Identity();
}

void AnnotationSession::On(const PreviewPoseCommand& command) {
  if (view_.placement ? command.id == view_.placement->instance : command.id == view_.selected) {
    preview_ = command.scan_from_object;
  }
}

/// The key frames in which candidates are compared show them, too.
void AnnotationSession::TakeImages(const PlacementQuestion& question, std::uint64_t asked_by,
                                   const PlacementImages& chosen) {
  auto images = std::make_shared<InstanceImages>();
  images->instance = question.instance;
  images->model_name = question.model;
  images->scale = question.scale;
  images->placement = asked_by;
  images->model = chosen.model();
  images->images = images->apart.used = chosen.images();
  images_ = std::move(images);
  ++view_.images_number;
  checked_.reset();
  WantChecks();
}

void AnnotationSession::On(const RefineInstanceCommand& command) {
  const AnnotatedInstance* instance = project_->document().Find(command.id);
  if (instance == nullptr || models_ == nullptr) return Refuse("Select an object first.");
  if (instance->locked) return Refuse("'" + command.id + "' is locked; unlock it first.");
  const auto id = models_->Find(instance->model);
  RefinementTask task;
  task.by = command.by;
  task.up_in_scan = up_in_scan();
  // The images cannot tell how something is tilted.
  const bool tilts =
      instance->may_tilt && scan_.target != nullptr && command.by != RefineBy::kImages;
  const bool by_images = command.by != RefineBy::kScan && sequence_ != nullptr && !tilts;
  if (command.by == RefineBy::kImages && !by_images) return Refuse("There is no sequence.");
  if (command.by != RefineBy::kImages && (scan_.target != nullptr || !by_images)) {
    task.scan =
        TaskFor(id ? id->value : -1, instance->scan_from_object, command.on_floor, instance->scale);
    if (!task.scan) return;
  }
  if (by_images && outlines_ == nullptr) return Refuse("The outlines are still being prepared.");
  const bool floor_bound = command.on_floor && id &&
                           models_->model(*id).support == Support::kFloor &&
                           project_->document().floor_in_scan.has_value();
  if (tilts) {
    task.motion = FreeMotion::kRigid;
  } else if (floor_bound) {
    task.motion = FreeMotion::kAzimuthAndHorizontal;
  }
  DropProposals();
  RefinementView refinement;
  refinement.instance = command.id;
  refinement.by = command.by;
  refinement.scan_from_object = instance->scan_from_object;
  refinement.scale = instance->scale;
  task.free_scale = instance->may_scale;
  refinement.has_scan = task.scan.has_value();
  refinement.has_images = by_images;
  view_.refinement = refinement;
  const bool chosen = images_ != nullptr && images_->placement == 0 &&
                      images_->instance == command.id &&
                      images_->Suit(project_->document(), *instance);
  if (chosen) task.images = images_;
  refined_on_scan_ = task.scan;
  Propose({"Refining " + command.id, true,
           [task, refinement, by_images, pace = refine_pace_ms_, sequence = sequence_,
            outlines = outlines_, document = project_->document()](
               const WorkContext& work, const auto& emit) mutable -> Update {
             if (by_images) {
               task.occluders = outlines->OccludersOf(document, refinement.instance);
               if (task.images == nullptr) {
                 const auto read =
                     ReadInstanceImages(sequence, document, refinement.instance, *outlines, work);
                 if (read) task.images = std::make_shared<const InstanceImages>(*read);
               }
             }
             RefinementView now = refinement;
             SolveScale(outlines.get(), work, task, now);
             const auto step = [&](const RefinementView& view) {
               emit([view](AnnotationSession& session) { session.view_.refinement = view; });
             };
             RefineInstance(task, work, pace, step, now);
             return [now, images = task.images, scan = task.scan](AnnotationSession& session) {
               session.refined_on_scan_ = scan;
               if (images != nullptr && images != session.images_) {
                 session.images_ = images;
                 ++session.view_.images_number;
               }
               session.view_.refinement = now;
               session.preview_ = now.scan_from_object;
               session.checked_.reset();
               session.WantChecks();
             };
           }});
}

void AnnotationSession::On(const ChooseRefinementCommand& command) {
  if (!view_.refinement || view_.refinement->running) return;
  for (const RefinedPose& found : view_.refinement->found) {
    if (found.by != command.by) continue;
    const RefinedPose chosen = found;
    ProposePose(chosen, refined_on_scan_ ? &*refined_on_scan_ : nullptr, *view_.refinement);
    ++view_.proposal_number;
    preview_ = chosen.scan_from_object;
    return;
  }
}

}  // namespace plumbline
