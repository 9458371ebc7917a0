// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/annotation_process.h"

#include <exception>
#include <utility>

#include "engine/base/log.h"

namespace plumbline {

AnnotationProcess::AnnotationProcess(AnnotationChoice choice, std::function<void()> on_publish)
    : choice_(std::move(choice)), on_publish_(std::move(on_publish)) {
  auto opening = std::make_shared<AnnotationSnapshot>();
  opening->busy = "Opening";
  snapshot_.Publish(std::move(opening));
  worker_ = std::jthread([this] { Work(); });
  thread_ = std::jthread([this] { Run(); });
}

AnnotationProcess::~AnnotationProcess() {
  inbox_.Close();
  if (thread_.joinable()) thread_.join();
  job_stop_.request_stop();
  orders_.Close();
  if (worker_.joinable()) worker_.join();
}

std::optional<std::uint64_t> AnnotationProcess::Post(AnnotationCommand command) {
  const std::uint64_t number = posted_ + 1;
  const bool taken =
      inbox_.TryPush([command = std::move(command), number](AnnotationSession& session) {
        session.Apply(command, number);
      });
  if (!taken) {
    log::warn("the annotation does not keep up with its commands; one was dropped");
    return std::nullopt;
  }
  return posted_ = number;
}

void AnnotationProcess::Run() {
  try {
    auto session = AnnotationSession::Open(choice_);
    if (!session.ok()) return Fail(session.error().message);
    Loop(**session);
    (*session)->Close();
  } catch (const std::exception& error) {
    Fail(std::string("This is a bug in Plumbline; every edit before it is in the journal: ") +
         error.what());
  }
}

void AnnotationProcess::Loop(AnnotationSession& session) {
  StartJob(session);
  Publish(session);
  while (auto update = inbox_.Pop()) {
    (*update)(session);
    while (auto more = inbox_.TryPop()) (*more)(session);
    if (session.TakeCancel() && can_cancel_) job_stop_.request_stop();
    StartJob(session);
    Publish(session);
  }
}

void AnnotationProcess::StartJob(AnnotationSession& session) {
  if (busy_) return;
  auto job = session.TakeJob();
  if (!job) return;
  busy_ = true;
  stage_ = job->stage;
  can_cancel_ = job->can_cancel;
  job_stop_ = std::stop_source();
  orders_.Push({std::move(*job), job_stop_.get_token()});
}

/// The second thread: one job after the other.
void AnnotationProcess::Work() {
  while (auto order = orders_.Pop()) {
    Update result = [](AnnotationSession&) {};
    try {
      const WorkContext work{[](const Progress&) {}, order->stop};
      result = order->job.run(work, [this](Update update) { inbox_.Push(std::move(update)); });
    } catch (const std::exception& error) {
      log::error("{}: this is a bug in Plumbline: {}", order->job.stage, error.what());
      result = [](AnnotationSession& session) { session.Apply(CancelProposalCommand{}); };
    }
    inbox_.Push([this, result = std::move(result)](AnnotationSession& session) {
      busy_ = can_cancel_ = false;
      stage_.clear();
      result(session);
    });
  }
}

void AnnotationProcess::Publish(const AnnotationSession& session) {
  auto snapshot = std::make_shared<AnnotationSnapshot>(session.Snapshot());
  snapshot->busy = stage_;
  snapshot->can_cancel = can_cancel_;
  snapshot_.Publish(std::move(snapshot));
  if (on_publish_) on_publish_();
}

void AnnotationProcess::Fail(const std::string& message) {
  log::error("{}", message);
  auto failed = std::make_shared<AnnotationSnapshot>(*snapshot_.Latest());
  failed->state = AnnotationSnapshot::State::kFailed;
  failed->failure = message;
  failed->busy.clear();
  snapshot_.Publish(std::move(failed));
  if (on_publish_) on_publish_();
}

}  // namespace plumbline
