// SPDX-License-Identifier: Apache-2.0
// The part of the session that changes the project, saves and exports it.
#include <algorithm>
#include <filesystem>
#include <utility>

#include "engine/annotation/annotation_export.h"
#include "engine/session/annotation_session.h"
#include "engine/session/run_drafts.h"

namespace plumbline {
namespace {

/// VISMA alone has fragments.
std::string WhatWasExported(const AnnotationDocument& document, const ExportRequest& request) {
  std::string what = std::to_string(document.instances.size()) + " objects";
  const int fragments = document.NumFragments();
  if (request.format == "visma" && fragments > 0)
    what += " and " + std::to_string(fragments) + " fragments";
  return what + " written to " + request.out.string();
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
  ChangeInstance edit;
  edit.id = command.id;
  edit.set.scan_from_object = command.scan_from_object;
  edit.set.seconds_spent = instance->seconds_spent + SpentSinceLastEdit();
  Edit(edit);
}

void AnnotationSession::On(const ChangeInstanceCommand& command) {
  ChangeInstance edit{command.id, command.set};
  if (const auto& model = command.set.model) {
    const auto id = models_ != nullptr ? models_->Find(*model) : std::nullopt;
    if (!id) return Refuse("The database has no model '" + *model + "'.");
    edit.set.category = models_->model(*id).category;
  }
  if (!Edit(edit)) return;
  if (command.set.id && view_.selected == command.id) view_.selected = *command.set.id;
}

void AnnotationSession::On(const RemoveInstanceCommand& command) {
  DropProposals();
  if (Edit(RemoveInstance{command.id}) && view_.selected == command.id) view_.selected.clear();
}

void AnnotationSession::On(const DuplicateInstanceCommand& command) {
  const AnnotatedInstance* instance = project_->document().Find(command.id);
  if (instance == nullptr) return Refuse("Select an object first.");
  AnnotatedInstance copy = *instance;
  copy.id = FreeId(copy.model);
  copy.scan_from_object = command.scan_from_object;
  copy.annotator = view_.annotator;
  copy.locked = copy.hidden = false;
  copy.seconds_spent = SpentSinceLastEdit();
  if (Edit(AddInstance{copy, std::nullopt})) view_.selected = copy.id;
}

void AnnotationSession::On(const UndoCommand&) {
  DropProposals();
  const auto label = project_->UndoLabel();
  const Status done = project_->Undo();
  done.ok() ? Answer("Undone: " + label.value_or("")) : Refuse(done.error().message);
  FollowCrops();
}

void AnnotationSession::On(const RedoCommand&) {
  DropProposals();
  const auto label = project_->RedoLabel();
  const Status done = project_->Redo();
  done.ok() ? Answer("Done again: " + label.value_or("")) : Refuse(done.error().message);
  FollowCrops();
}

void AnnotationSession::On(const DropRecoveredCommand&) {
  DropProposals();
  const std::size_t count = std::exchange(view_.num_recovered, 0);
  for (std::size_t i = 0; i < count && project_->UndoLabel(); ++i) {
    if (const Status done = project_->Undo(); !done.ok()) return Refuse(done.error().message);
  }
  view_.notices.clear();
  Answer("Undone; Redo restores it");
  FollowCrops();
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
       [document, request, frames, models = models_, sequence = sequence_,
        scan = project_->Resolve(document.scan)](const WorkContext& work, const auto&) -> Update {
         const ExchangeInputs inputs{models.get(), sequence.get(), frames};
         const Status written = ExportAnnotation(document, inputs, scan, request, work);
         ExportView view{false, "", ""};
         if (written.ok()) {
           view.done = WhatWasExported(document, request);
         } else {
           view.problem = written.error().message;
         }
         return [view](AnnotationSession& session) {
           session.view_.exported = view;
           session.Answer(view.problem.empty() ? view.done : view.problem, !view.problem.empty());
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
