// SPDX-License-Identifier: Apache-2.0
// The part of the session that knows of the work itself: how long, how far, what comes next.
#include <cmath>
#include <utility>

#include "engine/session/annotation_queue.h"
#include "engine/session/annotation_session.h"

namespace plumbline {

std::optional<std::string> AnnotationSession::WorkedOn() const {
  if (view_.refinement) return view_.refinement->instance;
  if (view_.placement) return view_.placement->instance;  // "" is WorkTime::kNext
  if (placing_) return WorkTime::kNext;
  if (project_->document().Find(view_.selected) != nullptr) return view_.selected;
  return std::nullopt;
}

Edit AnnotationSession::WithTimeSpent(const plumbline::Edit& edit) const {
  const auto* change = std::get_if<ChangeInstance>(&edit);
  const auto* removal = std::get_if<RemoveInstance>(&edit);
  EditGroup group{DescribeEdit(edit), {}};
  plumbline::Edit main = edit;
  for (const AnnotatedInstance& instance : project_->document().instances) {
    const double seconds = work_time_.ToWrite(instance.id);
    if (seconds <= 0 || (removal != nullptr && removal->id == instance.id)) continue;
    const double spent = std::round(10 * (instance.seconds_spent + seconds)) / 10;
    if (change != nullptr && change->id == instance.id) {
      std::get<ChangeInstance>(main).set.seconds_spent = spent;
      continue;
    }
    ChangeInstance time;
    time.id = instance.id;
    time.set.seconds_spent = spent;
    group.edits.push_back(time);
  }
  if (group.edits.empty()) return main;
  group.edits.push_back(std::move(main));
  return group;
}

void AnnotationSession::WriteTimeSpent() {
  constexpr double kGlance_s = 5;
  const AnnotationDocument& document = project_->document();
  if (document.Stage() == WorkStage::kDone) return;
  double all_s = 0;
  for (const AnnotatedInstance& instance : document.instances)
    all_s += work_time_.ToWrite(instance.id);
  if (all_s < kGlance_s) return;
  Edit(EditGroup{"Note the time spent", {}});
}

void AnnotationSession::KeepTimeSpent(const std::vector<AnnotatedInstance>& before) {
  for (const AnnotatedInstance& old : before) {
    const AnnotatedInstance* now = project_->document().Find(old.id);
    if (now != nullptr) work_time_.Written(old.id, now->seconds_spent - old.seconds_spent);
  }
}

void AnnotationSession::On(const ActivityCommand& command) {
  const bool ended = placing_ && !command.placing && !view_.placement;
  placing_ = command.placing;
  if (!ended) return;
  const bool selected = project_->document().Find(view_.selected) != nullptr;
  selected ? work_time_.GiveNextTo(view_.selected) : work_time_.Forget(WorkTime::kNext);
}

void AnnotationSession::On(const SetStageCommand& command) {
  auto next = NextState(project_->document().state, command.stage, view_.annotator, command.note);
  if (!next) return Refuse(next.error().message);
  const bool done = next->stage == WorkStage::kDone;
  const bool reviewed = !next->reviewer.empty();
  if (!Edit(SetState{*next})) return;
  Answer(next->stage == WorkStage::kToReview ? "Handed over for review"
         : done && reviewed                  ? "Done, and reviewed by " + next->reviewer
         : done                              ? "Done; nobody has reviewed it"
                                             : "Back in work");
}

void AnnotationSession::On(const ListQueueCommand& command) {
  if (!command.folder.empty()) queue_folder_ = command.folder;
  if (queue_folder_.empty()) queue_folder_ = project_->file().parent_path();
  jobs_.push_back({"Reading the folder", false,
                   [folder = queue_folder_](const WorkContext&, const auto&) -> Update {
                     AnnotationQueueView queue;
                     queue.folder = folder.string();
                     auto entries = ReadQueue(folder);
                     if (entries)
                       queue.entries = std::move(*entries);
                     else
                       queue.problem = entries.error().message;
                     return [queue](AnnotationSession& session) {
                       session.view_.queue = queue;
                       for (std::size_t i = 0; i < queue.entries.size(); ++i) {
                         std::error_code ignored;
                         if (std::filesystem::equivalent(queue.entries[i].path,
                                                         session.project_->file(), ignored))
                           session.view_.queue->open = i;
                       }
                     };
                   }});
}

}  // namespace plumbline
