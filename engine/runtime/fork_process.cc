// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/fork_process.h"

#include <exception>
#include <utility>

#include "engine/base/log.h"

namespace plumbline {

ForkProcess::ForkProcess(ForkChoice choice, std::function<void()> on_publish)
    : choice_(std::move(choice)), on_publish_(std::move(on_publish)) {
  state_ = {ForkState::kRunning, choice_.out.string(), "Opening", 0, 0};
  view_.Publish(std::make_shared<const ForkView>(state_));
  thread_ = std::jthread([this](std::stop_token stop) { Run(stop); });
}

ForkProcess::~ForkProcess() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void ForkProcess::Run(std::stop_token stop) {
  const WorkContext work{[this](const Progress& progress) {
                           state_.message = std::string(progress.stage);
                           state_.done = progress.done;
                           state_.total = progress.total;
                           Publish();
                         },
                         stop};
  Status status;
  try {
    status = ForkRun(choice_, work);
  } catch (const std::exception& error) {
    status =
        Error{ErrorCode::kInvalidInput, std::string("This is a bug in Plumbline: ") + error.what()};
  }
  state_.state = status.ok()                                    ? ForkState::kDone
                 : status.error().code == ErrorCode::kCancelled ? ForkState::kCancelled
                                                                : ForkState::kFailed;
  state_.message = status.ok() ? "" : status.error().message;
  if (state_.state == ForkState::kFailed) log::error("{}", state_.message);
  Publish();
}

void ForkProcess::Publish() {
  view_.Publish(std::make_shared<const ForkView>(state_));
  on_publish_();
}

}  // namespace plumbline
