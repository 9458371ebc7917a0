// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "engine/base/queue.h"
#include "engine/session/annotation_session.h"

namespace plumbline {

/// Gives an AnnotationSession a thread for commands and one for its long work. Nobody waits for it:
/// Post returns at once and the slot holds the newest state. The destructor stops what runs and
/// joins.
class AnnotationProcess {
 public:
  /// @param on_publish  Called on the process's thread after every publication. May be empty.
  AnnotationProcess(AnnotationChoice choice, std::function<void()> on_publish);
  ~AnnotationProcess();
  AnnotationProcess(const AnnotationProcess&) = delete;
  AnnotationProcess& operator=(const AnnotationProcess&) = delete;

  /// From one thread. The command's number, counted from 1: the snapshot's `last_command` tells
  /// when it was carried out. Nothing if it was dropped, because the session does not keep up.
  std::optional<std::uint64_t> Post(AnnotationCommand command);
  /// Never null.
  std::shared_ptr<const AnnotationSnapshot> Snapshot() const { return snapshot_.Latest(); }

 private:
  using Update = AnnotationSession::Update;

  void Run();
  void Loop(AnnotationSession& session);
  void Work();
  void StartJob(AnnotationSession& session);
  void Publish(const AnnotationSession& session);
  void Fail(const std::string& message);

  AnnotationChoice choice_;
  std::function<void()> on_publish_;
  std::uint64_t posted_ = 0;
  BoundedQueue<Update> inbox_{4096};
  SnapshotSlot<AnnotationSnapshot> snapshot_;

  struct Order {
    AnnotationSession::Job job;
    std::stop_token stop;
  };
  BoundedQueue<Order> orders_{1};
  // Of the command thread only.
  bool busy_ = false, can_cancel_ = false;
  std::string stage_;
  std::stop_source job_stop_;

  std::jthread worker_, thread_;  ///< Last: they use all of the above.
};

}  // namespace plumbline
