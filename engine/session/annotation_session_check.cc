// SPDX-License-Identifier: Apache-2.0
// The part of the session that looks for what is wrong.
#include <algorithm>
#include <utility>

#include "engine/annotation/image_check.h"
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
    if (compared->second.scale != instance.scale) continue;
    const auto finding =
        CheckAgreement(instance.id, compared->second.agreement, compared->second.images);
    if (finding) findings.push_back(*finding);
  }
  return findings;
}

void AnnotationSession::MakeChecklist() {
  auto& list = view_.checklist.findings;
  list.clear();
  const AnnotationDocument& document = project_->document();
  const auto add = [&](const AnnotationFinding& finding) {
    FindingView view{finding.kind, finding.sentence, finding.instances, finding.IsError()};
    view.can_accept = AcceptanceOf(finding, document).has_value();
    if (const AcceptedFinding* accepted = FindAcceptance(finding, document)) {
      view.accepted = true;
      view.accepted_by = accepted->by;
      view.accepted_note = accepted->note;
    }
    list.push_back(std::move(view));
  };
  for (const AnnotationFinding& finding : findings_) add(finding);
  for (const AnnotationFinding& finding : AgreementFindings()) add(finding);
  const auto rank = [](const FindingView& finding) {
    return finding.accepted ? 2 : finding.error ? 0 : 1;
  };
  std::stable_sort(list.begin(), list.end(),
                   [&](const FindingView& a, const FindingView& b) { return rank(a) < rank(b); });
}

void AnnotationSession::On(const AcceptFindingCommand& command) {
  if (!command.accepted) {
    if (Edit(ReopenFinding{command.kind, command.instances})) MakeChecklist();
    return;
  }
  std::vector<AnnotationFinding> findings = AgreementFindings();
  findings.insert(findings.begin(), findings_.begin(), findings_.end());
  const auto found = std::find_if(findings.begin(), findings.end(), [&](const auto& finding) {
    return finding.kind == command.kind && finding.instances == command.instances;
  });
  if (found == findings.end()) return Refuse("This is not found any more.");
  auto accepted = AcceptanceOf(*found, project_->document());
  if (!accepted) return Refuse("Only what was found about placed objects can be accepted.");
  accepted->by = view_.annotator;
  accepted->note = command.note;
  if (Edit(AcceptFinding{std::move(*accepted), std::nullopt})) MakeChecklist();
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
                                     images->images->images().size(), instance.scale};
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
