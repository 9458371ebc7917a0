// SPDX-License-Identifier: Apache-2.0
// The part of the session that changes the project, saves and exports it.
#include <algorithm>
#include <filesystem>
#include <utility>

#include "engine/session/annotation_session.h"
#include "engine/session/place_beside.h"
#include "engine/session/run_drafts.h"

namespace plumbline {
namespace {

/// VISMA alone has fragments.
std::string WhatWasExported(const AnnotationDocument& document, const ExportRequest& request,
                            std::size_t accepted) {
  std::string what = std::to_string(document.instances.size()) + " objects";
  const int fragments = document.NumFragments();
  if (request.format == "visma" && fragments > 0)
    what += " and " + std::to_string(fragments) + " fragments";
  what += " written to " + request.out.string();
  const auto scaled = std::count_if(document.instances.begin(), document.instances.end(),
                                    [](const auto& instance) { return instance.scale != 1; });
  if (scaled > 0 &&
      (request.format == "visma" || request.format == "bop" || request.format == "labelfusion")) {
    what += "; " + std::to_string(scaled) + " scaled objects have models of their own size";
  }
  if (accepted > 0) {
    what += "; " + std::to_string(accepted) + (accepted == 1 ? " finding was" : " findings were") +
            " accepted";
  }
  return what;
}

/// Puts an export into its place.
ExportView Taken(StagedExport& staged, const std::string& what) {
  const auto kept = staged.Take();
  if (!kept) return {false, kept.error().message, ""};
  const bool replaced = !kept->empty();
  return {false, "", what + (replaced ? "; what was there is kept as " + kept->string() : "")};
}

}  // namespace

void AnnotationSession::On(const SelectInstanceCommand& command) {
  if (view_.refinement && view_.refinement->instance != command.id) DropProposals();
  view_.selected = command.id;
}

void AnnotationSession::On(const SetInstancePoseCommand& command) {
  const AnnotatedInstance* instance = project_->document().Find(command.id);
  if (instance == nullptr) return Refuse("There is no object '" + command.id + "'.");
  if (view_.refinement) DropProposals();
  work_time_.GiveNextTo(command.id);
  const auto moved = [](const std::string& id, const Eigen::Isometry3d& scan_from_object) {
    ChangeInstance edit;
    edit.id = id;
    edit.set.scan_from_object = scan_from_object;
    return edit;
  };
  const ChangeInstance first = moved(command.id, command.scan_from_object);
  EditGroup all{"Move " + std::to_string(1 + command.and_also.size()) + " objects", {first}};
  for (const InstancePose& other : command.and_also)
    all.edits.push_back(moved(other.id, other.scan_from_object));
  Edit(command.and_also.empty() ? plumbline::Edit(first) : plumbline::Edit(all));
}

void AnnotationSession::On(const ChangeInstanceCommand& command) {
  ChangeInstance edit{command.id, command.set};
  EditGroup all{"Change " + std::to_string(1 + command.and_also.size()) + " objects", {}};
  if (const auto& model = command.set.model) {
    const auto id = models_ != nullptr ? models_->Find(*model) : std::nullopt;
    if (!id) return Refuse("The database has no model '" + *model + "'.");
    edit.set.category = models_->model(*id).category;
  }
  all.edits.push_back(edit);
  for (const std::string& id : command.and_also) {
    edit.id = id;
    all.edits.push_back(edit);
  }
  if (!Edit(all.edits.size() == 1 ? all.edits.front() : plumbline::Edit(all))) return;
  if (command.set.id && view_.selected == command.id) view_.selected = *command.set.id;
}

void AnnotationSession::On(const RemoveInstanceCommand& command) {
  DropProposals();
  std::vector<std::string> ids = command.and_also;
  ids.insert(ids.begin(), command.id);
  EditGroup all{"Remove " + std::to_string(ids.size()) + " objects", {}};
  for (const std::string& id : ids) all.edits.push_back(RemoveInstance{id});
  if (!Edit(all.edits.size() == 1 ? all.edits.front() : plumbline::Edit(all))) return;
  for (const std::string& id : ids) {
    work_time_.Forget(id);
    if (view_.selected == id) view_.selected.clear();
  }
}

void AnnotationSession::On(const DuplicateInstanceCommand& command) {
  if (project_->document().Find(command.id) == nullptr) return Refuse("Select an object first.");
  std::vector<std::string> ids = command.and_also;
  ids.insert(ids.begin(), command.id);
  AnnotationDocument with_copies = project_->document();  // So that none stands in another.
  EditGroup all{"Duplicate " + std::to_string(ids.size()) + " objects", {}};
  for (const std::string& id : ids) {
    const AnnotatedInstance* instance = project_->document().Find(id);
    if (instance == nullptr) continue;
    AnnotatedInstance copy = *instance;
    copy.id = with_copies.FreeId(copy.model);
    copy.scan_from_object = PlaceBeside(*instance, with_copies, models_.get());
    copy.annotator = view_.annotator;
    copy.locked = copy.hidden = false;
    copy.seconds_spent = 0;
    with_copies.instances.push_back(copy);
    all.edits.push_back(AddInstance{copy, std::nullopt});
  }
  DropProposals();
  const std::string first = std::get<AddInstance>(all.edits.front()).instance.id;
  if (Edit(all.edits.size() == 1 ? all.edits.front() : plumbline::Edit(all)))
    view_.selected = first;
}

void AnnotationSession::On(const UndoCommand&) {
  DropProposals();
  const auto label = project_->UndoLabel();
  const auto before = project_->document().instances;
  const Status done = project_->Undo();
  KeepTimeSpent(before);
  done.ok() ? Answer("Undone: " + label.value_or("")) : Refuse(done.error().message);
  FollowCrops();
  FollowScan();
}

void AnnotationSession::On(const RedoCommand&) {
  DropProposals();
  const auto label = project_->RedoLabel();
  const auto before = project_->document().instances;
  const Status done = project_->Redo();
  KeepTimeSpent(before);
  done.ok() ? Answer("Done again: " + label.value_or("")) : Refuse(done.error().message);
  FollowCrops();
  FollowScan();
}

void AnnotationSession::On(const DropRecoveredCommand&) {
  DropProposals();
  view_.num_recovered = 0;
  const auto undone = project_->UndoRecovered();
  FollowCrops();
  FollowScan();
  if (!undone) return Refuse(undone.error().message);
  view_.notices.clear();
  Answer(*undone ? "Undone; Redo restores it"
                 : "Undone; but they had undone edits that were saved, and these stay undone");
}

void AnnotationSession::On(const SaveProjectCommand& command) {
  const Status saved = command.file.empty() ? project_->Save() : project_->SaveAs(command.file);
  if (!saved.ok()) return Refuse(saved.error().message);
  if (!command.file.empty()) view_.read_only = false;
  view_.num_recovered = 0;
  Answer("Saved as " + project_->file().string());
}

void AnnotationSession::On(const SetAnnotatorCommand& command) { view_.annotator = command.name; }

void AnnotationSession::On(const DismissNoticesCommand&) {
  view_.notices.clear();
  view_.num_recovered = 0;
}

void AnnotationSession::On(const ExportCommand& command) {
  const AnnotationDocument& document = project_->document();
  view_.exported = ExportView{};
  staged_.reset();
  const auto refuse = [&](const std::string& why) {
    view_.exported = ExportView{false, why, ""};
    Refuse(why);
  };
  if (document.instances.empty() && document.crops.empty()) {
    return refuse("There is nothing to export yet: place an object or cut one out.");
  }
  ExportRequest request{command.format, command.out,
                        command.frame == "level"   ? PoseFrame::kLevel
                        : command.frame == "world" ? PoseFrame::kWorld
                                                   : PoseFrame::kScan};
  std::vector<int> frames;
  for (int i = 0; sequence_ != nullptr && i < sequence_->num_frames();
       i += std::max(1, command.every)) {
    frames.push_back(i);
  }
  jobs_.push_back(
      {"Exporting", false,
       [document, request, frames, low = AgreementFindings(), despite = command.despite_findings,
        models = models_, sequence = sequence_,
        scan = project_->Resolve(document.scan)](const WorkContext& work, const auto&) -> Update {
         const ExchangeInputs inputs{models.get(), sequence.get(), frames};
         std::vector<AnnotationFinding> findings = CheckAnnotations(document, inputs);
         findings.insert(findings.begin(), low.begin(), low.end());
         std::vector<std::string> open;
         std::size_t accepted = 0;
         for (const AnnotationFinding& finding : findings) {
           if (!finding.IsError()) continue;
           if (FindAcceptance(finding, document) != nullptr)
             ++accepted;
           else
             open.push_back(finding.sentence);
         }
         if (!despite && !open.empty()) {
           return [open](AnnotationSession& session) {
             ExportView asking{false, "", ""};
             asking.open_findings = open;
             session.view_.exported = asking;
             session.Answer("Nothing was written: " + std::to_string(open.size()) +
                            " findings are open.");
           };
         }
         auto written = StagedExport::Write(document, inputs, scan, request, work);
         std::shared_ptr<StagedExport> waits;
         ExportView view{false, "", ""};
         if (!written.ok()) {
           view.problem = written.error().message;
         } else if ((*written)->replaces()) {
           waits = std::move(*written);
           view.asks = true;
           view.out = waits->out().string();
           view.differences = waits->Differences();
           view.done = WhatWasExported(document, request, accepted);
         } else {
           view = Taken(**written, WhatWasExported(document, request, accepted));
         }
         return [view, waits](AnnotationSession& session) {
           session.view_.exported = view;
           session.staged_ = waits;
           if (view.asks) return session.Answer(view.out + " is there already, and differs.");
           session.Answer(view.problem.empty() ? view.done : view.problem, !view.problem.empty());
         };
       }});
}

void AnnotationSession::On(const AnswerExportCommand& command) {
  const auto staged = std::exchange(staged_, nullptr);
  if (staged == nullptr) return;
  if (!command.replace) {
    view_.exported.reset();
    return Answer("Nothing was exported; " + staged->out().string() + " is as it was.");
  }
  view_.exported = Taken(*staged, view_.exported->done);
  const std::string& problem = view_.exported->problem;
  Answer(problem.empty() ? view_.exported->done : problem, !problem.empty());
}

void AnnotationSession::On(const SetScanUnitCommand& command) {
  if (command.metres_per_unit == 1) return view_.doubted_size_m.reset();
  if (!project_->document().instances.empty())
    return Refuse("Objects have been placed in this scan, so its unit stays as it is.");
  if (scan_.full == nullptr) return Refuse("The scan has not been read yet.");
  view_.doubted_size_m.reset();
  jobs_.push_back(
      {"Making a copy in metres", false,
       [full = scan_.full, factor = command.metres_per_unit, file = scan_file_,
        folder = project_->file().parent_path()](const WorkContext&, const auto&) -> Update {
         const auto copy = WriteScanInMetres(*full, factor, file, folder);
         return [copy, factor](AnnotationSession& session) {
           if (!copy) return session.Refuse(copy.error().message);
           const AnnotationDocument& document = session.project_->document();
           EditGroup group{"Take the scan in metres", {}};
           group.edits.push_back(SetInputs{NameInProject(*copy, session.project_->file()),
                                           document.models, document.sequence});
           if (auto floor = document.floor_in_scan; floor && document.sequence.empty()) {
             (*floor)[3] *= factor;
             group.edits.push_back(SetGravity{document.gravity_in_scan, floor});
           }
           if (!session.Edit(group)) return;
           session.FollowScan();
           session.Answer("The scan in metres is " + copy->string());
         };
       }});
}

void AnnotationSession::On(const ImportDraftsCommand& command) {
  auto drafts = DraftsOfRun(project_->document(), command.run);
  if (!drafts) return Refuse(drafts.error().message);
  const std::string run = std::filesystem::path(command.run).filename().string();
  if (drafts->empty()) return Refuse(run + " has no confirmed objects.");
  const std::size_t count = drafts->size();
  EditGroup group{"Take drafts from " + run, {}};
  for (AnnotatedInstance& draft : *drafts) {
    draft.annotator = view_.annotator;
    group.edits.push_back(AddInstance{std::move(draft), std::nullopt});
  }
  if (Edit(group)) Answer(std::to_string(count) + " drafts taken from " + run);
}

}  // namespace plumbline
