// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <thread>

#include "engine/base/queue.h"
#include "engine/recording/run_fork.h"
#include "engine/snapshot/fork_view.h"

namespace plumbline {

/// Gives ForkRun a thread. The destructor stops it within a frame and joins; what is done stays in
/// its file.
class ForkProcess {
 public:
  /// @param on_publish  Called on the thread after every publication (to wake the window).
  ForkProcess(ForkChoice choice, std::function<void()> on_publish);
  ~ForkProcess();
  ForkProcess(const ForkProcess&) = delete;
  ForkProcess& operator=(const ForkProcess&) = delete;

  void Cancel() { thread_.request_stop(); }
  /// Never null.
  std::shared_ptr<const ForkView> View() const { return view_.Latest(); }

 private:
  void Run(std::stop_token stop);
  void Publish();

  ForkChoice choice_;
  std::function<void()> on_publish_;
  ForkView state_;
  SnapshotSlot<ForkView> view_;
  std::jthread thread_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
