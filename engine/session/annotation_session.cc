// SPDX-License-Identifier: Apache-2.0
#include "engine/session/annotation_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "engine/annotation/reopening.h"
#include "engine/base/log.h"
#include "engine/geometry/gravity.h"
#include "engine/session/annotation_queue.h"

namespace plumbline {
namespace {}  // namespace

double AnnotationSession::SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Result<std::unique_ptr<AnnotationSession>> AnnotationSession::Open(const AnnotationChoice& choice,
                                                                   Clock clock,
                                                                   int refine_pace_ms) {
  auto opened = OpenAnnotation(choice);
  if (!opened) return opened.error();
  return std::unique_ptr<AnnotationSession>(
      new AnnotationSession(std::move(*opened), choice, std::move(clock), refine_pace_ms));
}

AnnotationSession::AnnotationSession(OpenedAnnotation opened, const AnnotationChoice& choice,
                                     Clock clock, int refine_pace_ms)
    : project_(std::move(opened.project)),
      clock_(std::move(clock)),
      refine_pace_ms_(refine_pace_ms),
      work_time_(clock_()) {
  view_.state = AnnotationSnapshot::State::kReady;
  view_.read_only = opened.read_only;
  view_.notices = std::move(opened.notices);
  if (!opened.read_only) view_.num_recovered = project_->num_recovered();
  view_.annotator = choice.annotator;
  const AnnotationDocument& document = project_->document();
  view_.gravity_known =
      document.floor_in_scan.has_value() || document.gravity_in_scan != Eigen::Vector3d(0, 0, -1);
  QueueLoading();
  std::error_code ignored;
  queue_folder_ = std::filesystem::is_directory(choice.path, ignored) ? choice.path : choice.queue;
  if (!queue_folder_.empty()) On(ListQueueCommand{});
}

void AnnotationSession::Close() {
  if (view_.read_only) return;
  WriteTimeSpent();
  if (!project_->modified()) return;
  if (const Status saved = project_->Save(); !saved.ok())
    log::error("the project was not saved at the end: {}", saved.error().message);
}

std::optional<AnnotationSession::Job> AnnotationSession::TakeJob() {
  if (frame_wanted_) return FrameJob(*std::exchange(frame_wanted_, std::nullopt));
  if (jobs_.empty() && std::exchange(check_wanted_, false)) return CheckJob();
  if (jobs_.empty() && std::exchange(images_wanted_, false)) return ImagesJob();
  if (jobs_.empty() && AuditDue()) return AuditJob();
  if (jobs_.empty() && AgreementDue()) return AgreementJob();
  if (jobs_.empty()) return std::nullopt;
  Job job = std::move(jobs_.front());
  jobs_.pop_front();
  return job;
}

void AnnotationSession::Apply(const AnnotationCommand& command, std::uint64_t number) {
  const std::uint64_t answers = view_.answer_number;
  command_ = number;
  work_time_.NoteInput(clock_(), WorkedOn());
  // Every kind has an On of its own: one that is forgotten does not compile.
  std::visit([this](const auto& c) { On(c); }, command);
  const bool refused = view_.refused && view_.answer_number != answers;
  if (number > 0) view_.last_command = {number, refused ? view_.answer : ""};
  const bool previews = std::holds_alternative<PreviewPoseCommand>(command) ||
                        std::holds_alternative<ChooseRefinementCommand>(command) ||
                        std::holds_alternative<ActivityCommand>(command);
  if (!previews) {
    preview_.reset();
    checked_.reset();  // what hides it may have changed
  }
  WantChecks();
}

void AnnotationSession::Answer(std::string text, bool refused) {
  view_.answer = std::move(text);
  view_.refused = refused;
  ++view_.answer_number;
}

bool AnnotationSession::Edit(const plumbline::Edit& edit) {
  const std::vector<AnnotatedInstance> before = project_->document().instances;
  const bool was_done = project_->document().Stage() == WorkStage::kDone;
  const Status done =
      project_->Apply(WithTimeSpent(WithReopening(edit, project_->document(), view_.annotator)));
  if (done.ok()) {
    view_.num_recovered = 0;  // they are not the last ones any more
    for (const AnnotatedInstance& instance : before)
      work_time_.Written(instance.id, work_time_.ToWrite(instance.id));
    if (was_done && project_->document().Stage() == WorkStage::kInWork &&
        !std::holds_alternative<SetState>(edit)) {
      Answer("The project was done, and is in work again.");
    }
    return true;
  }
  Refuse(done.error().message);
  return false;
}

AnnotationSnapshot AnnotationSession::Snapshot() const {
  AnnotationSnapshot snapshot = view_;
  const AnnotationDocument& document = project_->document();
  snapshot.project_file = project_->file().string();
  snapshot.project_name = project_->file().filename().string();
  AddSequence(snapshot);
  snapshot.modified = project_->modified();
  if (const auto& problem = project_->journal_problem())
    snapshot.journal_problem = problem->message;
  snapshot.undo_label = project_->UndoLabel();
  snapshot.redo_label = project_->RedoLabel();
  snapshot.level_from_scan = document.LevelFromScan();
  snapshot.floor_known = document.floor_in_scan.has_value();
  snapshot.gravity_known = view_.gravity_known || snapshot.floor_known;
  snapshot.instances = document.instances;
  snapshot.num_fragments = document.NumFragments();
  for (AnnotatedInstance& instance : snapshot.instances)
    instance.seconds_spent += work_time_.Of(instance.id);
  snapshot.stage = document.Stage();
  snapshot.project_state = document.state;
  if (auto& queue = snapshot.queue; queue && queue->open)
    DescribeWork(document, queue->entries[*queue->open]);
  if (snapshot.Selected() == nullptr) snapshot.selected.clear();
  return snapshot;
}

}  // namespace plumbline
