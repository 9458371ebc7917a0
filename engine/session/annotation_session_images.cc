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
  const AnnotatedInstance* selected = project_->document().Find(view_.selected);
  if (outlines_ == nullptr) return;
  if (selected == nullptr) {
    view_.checks.reset();
    images_wanted_ = check_wanted_ = false;
    return;
  }
  const Eigen::Isometry3d pose = preview_.value_or(selected->scan_from_object);
  const bool other = images_ == nullptr || images_->instance != selected->id;
  if (other || (!preview_ && !images_->Suit(project_->document(), *selected))) {
    if (!view_.checks || view_.checks->instance != selected->id) {
      view_.checks = ImageChecksView{selected->id};
    }
    images_wanted_ = true;
    check_wanted_ = false;
  } else {
    images_wanted_ = false;
    if (!checked_ || checked_->matrix() != pose.matrix()) check_wanted_ = true;
  }
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
  const Eigen::Isometry3d pose = preview_.value_or(PoseOf(view_.selected));
  checked_ = pose;
  return {"", false,
          [images = images_, outlines = outlines_, document = project_->document(), pose](
              const WorkContext&, const auto&) -> Update {
            auto view = CheckPose(*images, pose, outlines->OccludersOf(document, images->instance));
            return [view = std::move(view)](AnnotationSession& session) {
              if (session.view_.selected == view.instance) session.view_.checks = view;
            };
          }};
}

Eigen::Isometry3d AnnotationSession::PoseOf(const std::string& id) const {
  const AnnotatedInstance* instance = project_->document().Find(id);
  return instance != nullptr ? instance->scan_from_object : Eigen::Isometry3d::Identity();
}

void AnnotationSession::On(const PreviewPoseCommand& command) {
  if (command.id == view_.selected) preview_ = command.scan_from_object;
}

void AnnotationSession::On(const RefineByImagesCommand& command) {
  const AnnotatedInstance* instance = project_->document().Find(command.id);
  if (instance == nullptr) return Refuse("Select an object first.");
  if (instance->locked) return Refuse("'" + command.id + "' is locked; unlock it first.");
  if (images_ == nullptr || images_->instance != command.id) {
    return Refuse("The key frames are still being chosen.");
  }
  const auto id = models_->Find(instance->model);
  const bool floor_bound = command.on_floor && id &&
                           models_->model(*id).support == Support::kFloor &&
                           project_->document().floor_in_scan.has_value();
  DropProposals();
  RefinementView refinement;
  refinement.instance = command.id;
  refinement.by_images = true;
  refinement.scan_from_object = instance->scan_from_object;
  view_.refinement = refinement;
  const FreeMotion motion =
      floor_bound ? FreeMotion::kAzimuthAndHorizontal : FreeMotion::kAzimuthAndTranslation;
  Propose({"Refining " + command.id + " by its images", true,
           [images = images_, outlines = outlines_, document = project_->document(), refinement,
            motion, up = up_in_scan()](const WorkContext& work, const auto&) -> Update {
             RefinementView now = refinement;
             const Occluders hides = outlines->OccludersOf(document, now.instance);
             RefineInImages(*images, hides, up, motion, work, now);
             return [now](AnnotationSession& session) {
               session.view_.refinement = now;
               session.preview_ = now.scan_from_object;
               session.WantChecks();
             };
           }});
}

}  // namespace plumbline
