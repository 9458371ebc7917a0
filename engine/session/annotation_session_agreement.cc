// SPDX-License-Identifier: Apache-2.0
// The part of the session that compares it with what somebody else placed in the same scan.
#include <utility>

#include "engine/annotation/pose_exchange.h"
#include "engine/evaluation/annotator_agreement.h"
#include "engine/session/annotation_session.h"

namespace plumbline {
namespace {

/// Poses in the scan's frame. Errors: of the project, or of the ground truth.
Result<GroundTruth> ReadOther(const std::filesystem::path& file) {
  if (!IsForAnnotation(file)) return ReadGroundTruth(file);
  const auto project = AnnotationProject::Open(file, AnnotationProject::Access::kRead);
  if (!project) return project.error();
  return GroundTruthOf((*project)->document(), PoseFrame::kScan);
}

AgreedRowView OnlyOne(const GroundTruthInstance& instance, bool in_second) {
  AgreedRowView row;
  (in_second ? row.second : row.first) = instance.id;
  row.second_model = instance.model;
  row.second_scale = instance.scale;
  row.second_from = instance.world_from_object;
  return row;
}

AgreementView ViewOf(const AnnotatorAgreement& agreement) {
  AgreementView view;
  view.running = false;
  for (const AgreedObject& object : agreement.objects) {
    AgreedRowView row = OnlyOne(object.second, true);
    row.first = object.first.id;
    row.same_model = object.same_model;
    row.copied = object.copied;
    row.horizontal_m = object.horizontal_m();
    row.height_m = object.difference_m.z();
    row.azimuth_rad = object.azimuth_rad;
    row.tilt_rad = object.tilt_rad;
    view.rows.push_back(std::move(row));
  }
  for (const auto& instance : agreement.only_first) view.rows.push_back(OnlyOne(instance, false));
  for (const auto& instance : agreement.only_second) view.rows.push_back(OnlyOne(instance, true));
  if (agreement.all.objects >= kLeastPooled) {
    view.pooled = agreement.all.objects;
    view.position_std_m = agreement.all.position_std_m;
    view.azimuth_std_rad = agreement.all.azimuth_std_rad;
  }
  return view;
}

}  // namespace

void AnnotationSession::On(const CompareWithCommand& command) {
  other_file_ = command.file;
  other_.reset();
  agreed_ = 0;
  view_.agreement.reset();
  if (command.file.empty()) return;
  view_.agreement = AgreementView{};
  view_.agreement->name = std::filesystem::path(command.file).filename().string();
}

bool AnnotationSession::AgreementDue() const {
  const bool models_known = models_ != nullptr || !view_.models_problem.empty();
  return !other_file_.empty() && models_known && agreed_ != project_->revision();
}

/// After every edit anew; the other's file is read once.
AnnotationSession::Job AnnotationSession::AgreementJob() {
  agreed_ = project_->revision();
  return {"", false,
          [document = project_->document(), models = models_, file = other_file_, other = other_](
              const WorkContext&, const auto&) mutable -> Update {
            std::string problem;
            if (other == nullptr) {
              auto read = ReadOther(file);
              if (read)
                other = std::make_shared<const GroundTruth>(std::move(*read));
              else
                problem = read.error().message;
            }
            AgreementView view;
            view.running = false;
            if (other != nullptr) {
              view = ViewOf(CompareAnnotators(GroundTruthOf(document, PoseFrame::kScan), *other,
                                              models.get()));
            }
            view.problem = problem;
            return [view, other, file](AnnotationSession& session) {
              if (session.other_file_ != file || !session.view_.agreement) return;
              const std::string name = session.view_.agreement->name;
              session.view_.agreement = view;
              session.view_.agreement->name = name;
              session.other_ = other;
            };
          }};
}

}  // namespace plumbline
