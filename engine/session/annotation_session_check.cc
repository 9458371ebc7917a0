// SPDX-License-Identifier: Apache-2.0
// The part of the session that looks for what is wrong.
#include <algorithm>
#include <utility>

#include "engine/session/annotation_session.h"

namespace plumbline {

bool AnnotationSession::AuditDue() const {
  const bool models_known = models_ != nullptr || !view_.models_problem.empty();
  return models_known &&
         (audited_ != project_->revision() || audited_models_ != view_.models_version);
}

AnnotationSession::Job AnnotationSession::AuditJob() {
  audited_ = project_->revision();
  audited_models_ = view_.models_version;
  return {"", false,
          [document = project_->document(), models = models_, sequence = sequence_,
           scan = scan_.full](const WorkContext&, const auto&) -> Update {
            ExchangeInputs inputs{models.get(), sequence.get(), {}, scan.get()};
            auto findings = CheckAnnotations(document, inputs);
            return [findings = std::move(findings)](AnnotationSession& session) {
              session.findings_ = findings;
              session.MakeChecklist();
            };
          }};
}

/// Of the objects that are where they were when they were compared.
std::vector<AnnotationFinding> AnnotationSession::AgreementFindings() const {
  std::vector<AnnotationFinding> findings;
  for (const AnnotatedInstance& instance : project_->document().instances) {
    const auto compared = compared_.find(instance.id);
    if (compared == compared_.end()) continue;
    if (compared->second.scan_from_object.matrix() != instance.scan_from_object.matrix()) continue;
    const auto finding =
        CheckAgreement(instance.id, compared->second.agreement, compared->second.images);
    if (finding) findings.push_back(*finding);
  }
  return findings;
}

void AnnotationSession::MakeChecklist() {
  auto& list = view_.checklist.findings;
  list.clear();
  const auto add = [&](const AnnotationFinding& finding) {
    list.push_back({finding.kind, finding.sentence, finding.instances, finding.IsError()});
  };
  for (const AnnotationFinding& finding : findings_) add(finding);
  for (const AnnotationFinding& finding : AgreementFindings()) add(finding);
  std::stable_partition(list.begin(), list.end(),
                        [](const FindingView& finding) { return finding.error; });
}

void AnnotationSession::On(const CompareAllCommand&) {
  if (sequence_ == nullptr) return Refuse("There is no sequence whose images could show them.");
  if (outlines_ == nullptr) return Refuse("The outlines are still being prepared.");
  DropProposals();
  view_.checklist.comparing = true;
  view_.checklist.compared = 0;
  view_.checklist.to_compare = static_cast<int>(project_->document().instances.size());
  Propose({"Comparing all objects with their images", true,
           [sequence = sequence_, outlines = outlines_, document = project_->document()](
               const WorkContext& work, const auto& emit) -> Update {
             for (const AnnotatedInstance& instance : document.instances) {
               if (work.stop.stop_requested()) break;
               const auto images =
                   ReadInstanceImages(sequence, document, instance.id, *outlines, work);
               std::optional<Compared> compared;
               if (images && images->images != nullptr) {
                 const auto checks =
                     CheckImages(*images->images, *images->model, instance.scan_from_object,
                                 outlines->OccludersOf(document, instance.id));
                 compared = Compared{instance.scan_from_object, MeanAgreement(checks),
                                     images->images->images().size()};
               }
               emit([id = instance.id, compared](AnnotationSession& session) {
                 ++session.view_.checklist.compared;
                 if (compared) session.compared_[id] = *compared;
                 session.MakeChecklist();
               });
             }
             return [](AnnotationSession& session) { session.view_.checklist.comparing = false; };
           }});
}

}  // namespace plumbline
