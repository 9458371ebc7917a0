// SPDX-License-Identifier: Apache-2.0
// The part of the session that brings a sequence into the frame of the scan.
#include <cmath>
#include <utility>

#include "engine/annotation/instance_masks.h"
#include "engine/annotation/scaled_models.h"
#include "engine/session/annotation_session.h"

namespace plumbline {

void AnnotationSession::On(const ShowFrameCommand& command) {
  if (sequence_ == nullptr) return Refuse("The project has no sequence.");
  const int frame = std::clamp(command.frame, 0, sequence_->num_frames() - 1);
  FrameView shown;
  shown.frame = frame;
  shown.masks = command.masks;
  if (view_.frame) {  // the one before, until this one is there
    shown.image = view_.frame->image;
    if (command.masks) shown.instances = view_.frame->instances;
  }
  view_.frame = shown;
  frame_wanted_ = frame;
}

AnnotationSession::Job AnnotationSession::FrameJob(int frame) {
  return {"", false,
          [sequence = sequence_, models = models_, document = project_->document(), frame,
           masks = view_.frame && view_.frame->masks](const WorkContext&, const auto&) -> Update {
            const auto read = sequence->ReadFrame(frame);
            Result<cv::Mat> instances = cv::Mat();
            if (masks) {
              ExchangeInputs inputs;
              inputs.sequence = sequence.get();
              const UnscaledAnnotations sized = WithScaledModels(document, models.get());
              inputs.models = sized.models != nullptr ? sized.models.get() : models.get();
              instances = VisibleInstances(sized.document, inputs, frame);
            }
            return [read, instances, frame, masks](AnnotationSession& session) {
              const auto& shown = session.view_.frame;
              if (!shown || shown->frame != frame || shown->masks != masks) return;
              session.view_.frame->image = read ? read->image : cv::Mat();
              session.view_.frame->problem = read ? "" : read.error().message;
              session.view_.frame->instances = instances ? *instances : cv::Mat();
              session.view_.frame->masks_problem = instances ? "" : instances.error().message;
              ++session.view_.frame_number;
            };
          }};
}

void AnnotationSession::On(const AddPairCommand& command) {
  Edit(AddPair{{command.in_scan, command.frame, command.pixel}, std::nullopt});
}

void AnnotationSession::On(const RemovePairCommand& command) {
  if (Edit(RemovePair{command.index}) && view_.sequence_alignment) DropProposals();
}

/// What it changes: the turn, and how far the cameras go in the mean.
void AnnotationSession::SetChange(SequenceAlignmentView& view) const {
  const Eigen::Isometry3d now =
      project_->document().scan_from_world.value_or(Eigen::Isometry3d::Identity());
  view.turn_rad =
      Eigen::AngleAxisd(now.linear().transpose() * view.scan_from_world.linear()).angle();
  double sum = 0;
  for (const Eigen::Vector3d& camera : cameras_in_world_) {
    sum += (view.scan_from_world * camera - now * camera).norm();
  }
  view.shift_m =
      cameras_in_world_.empty() ? 0 : sum / static_cast<double>(cameras_in_world_.size());
}

void AnnotationSession::On(const AlignSequenceCommand& command) {
  using How = AlignSequenceCommand::How;
  if (sequence_ == nullptr) return Refuse("The project has no sequence.");
  if (command.how == How::kPoints && scan_.target == nullptr) {
    return Refuse("The scan is still being prepared.");
  }
  DropProposals();
  SequenceAlignmentView view;
  view.how = command.how == How::kPairs    ? "pairs"
             : command.how == How::kPoints ? "points"
                                           : "objects";
  view_.sequence_alignment = view;
  Propose({"Registering the sequence", true,
           [view, command, sequence = sequence_, document = project_->document(),
            target = scan_.target](const WorkContext& work, const auto&) -> Update {
             std::vector<std::string> names;
             const auto found =
                 command.how == How::kPairs ? RegisterByPicks(document, *sequence, document.pairs)
                 : command.how == How::kPoints
                     ? RegisterByPoints(document, *sequence, *target, command.file, work)
                     : RegisterByObjects(document, *sequence, command.file, names);
             SequenceAlignmentView now = view;
             now.running = false;
             if (!found) {
               now.problem = found.error().message;
             } else {
               now.scan_from_world = found->scan_from_world;
               now.position_std_m = found->position_std_m;
               now.azimuth_std_rad = found->azimuth_std_rad;
               now.rmse_m = found->rmse_m;
               now.share = found->share;
               for (std::size_t i = 0; i < names.size(); ++i) {
                 now.residuals.push_back({names[i], found->residuals[i]});
               }
             }
             return [now](AnnotationSession& session) {
               session.view_.sequence_alignment = now;
               if (now.problem.empty()) session.SetChange(*session.view_.sequence_alignment);
             };
           }});
}

/// Where the sequence is by what is proposed, else by the project.
std::optional<Eigen::Isometry3d> AnnotationSession::ScanFromWorldNow() const {
  const auto& proposed = view_.sequence_alignment;
  if (proposed && !proposed->running && proposed->problem.empty()) return proposed->scan_from_world;
  return project_->document().scan_from_world;
}

std::vector<Eigen::Vector3d> AnnotationSession::CamerasInScan() const {
  const Eigen::Isometry3d scan_from_world =
      ScanFromWorldNow().value_or(Eigen::Isometry3d::Identity());
  std::vector<Eigen::Vector3d> cameras;
  for (const Eigen::Vector3d& camera : cameras_in_world_) {
    cameras.push_back(scan_from_world * camera);
  }
  return cameras;
}

void AnnotationSession::AddSequence(AnnotationSnapshot& snapshot) const {
  snapshot.has_sequence = sequence_ != nullptr;
  if (sequence_ == nullptr) return;
  const auto scan_from_world = ScanFromWorldNow();
  snapshot.sequence_registered = project_->document().scan_from_world.has_value();
  snapshot.num_frames = sequence_->num_frames();
  snapshot.frame_size = {sequence_->camera().width, sequence_->camera().height};
  snapshot.cameras_in_scan = CamerasInScan();
  for (const FramePick& pick : project_->document().pairs) {
    PairView pair{pick.in_scan, pick.frame, pick.pixel,
                  SeenAt(*sequence_, pick.frame, scan_from_world, pick.in_scan)};
    if (pair.seen_at) pair.residual_px = (*pair.seen_at - pick.pixel).norm();
    snapshot.pairs.push_back(pair);
  }
}

}  // namespace plumbline
