// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "engine/base/queue.h"
#include "engine/snapshot/networks_view.h"

namespace plumbline {

/// Says which networks there are, and what a file of the user's is, on a thread of its own.
class NetworkProcess {
 public:
  /// @param on_publish  Called on the thread after every publication (to wake the window).
  explicit NetworkProcess(std::function<void()> on_publish);
  ~NetworkProcess();
  NetworkProcess(const NetworkProcess&) = delete;
  NetworkProcess& operator=(const NetworkProcess&) = delete;

  /// Which of the listed ones are fetched now. Returns at once.
  void Look();
  /// Loads a file and runs it on a grey image. Returns at once.
  void LookAt(const std::string& file);
  /// Null before the first answer.
  std::shared_ptr<const NetworksView> View() const { return view_.Latest(); }

 private:
  void Run();
  void Publish(const NetworksView& view);

  std::function<void()> on_publish_;
  BoundedQueue<std::string> files_{8};  ///< "": none.
  SnapshotSlot<NetworksView> view_;
  std::jthread thread_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
