// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "engine/base/queue.h"
#include "engine/snapshot/networks_view.h"
#include "engine/vision/fetched_networks.h"

namespace plumbline {

/// Says which networks there are, what a file of the user's is, and fetches listed ones, on a
/// thread of its own.
class NetworkProcess {
 public:
  /// @param on_publish  Called on the thread after every publication (to wake the window).
  /// @param listed      Those that can be fetched.
  explicit NetworkProcess(std::function<void()> on_publish,
                          std::vector<ListedNetwork> listed = ListedNetworks());
  /// Stops a download; what has arrived is kept.
  ~NetworkProcess();
  NetworkProcess(const NetworkProcess&) = delete;
  NetworkProcess& operator=(const NetworkProcess&) = delete;

  /// Which of the listed ones are fetched now. Returns at once.
  void Look();
  /// Loads a file and runs it on a grey image. Returns at once.
  void LookAt(const std::string& file);
  /// Downloads a listed network into NetworksFolder(). Returns at once.
  void Fetch(const std::string& name);
  /// What has arrived is kept. Returns at once.
  void StopFetching();
  /// Null before the first answer.
  std::shared_ptr<const NetworksView> View() const { return view_.Latest(); }

 private:
  struct Looking {
    std::string file;  ///< "": none.
  };
  struct Fetching {
    std::string name;
    std::stop_token stop;
  };
  using Task = std::variant<Looking, Fetching>;

  void Run();
  void Do(const Looking& looking);
  void Do(const Fetching& fetching);
  void Publish();

  std::function<void()> on_publish_;
  std::vector<ListedNetwork> listed_;
  std::stop_source stop_fetching_;  ///< Of those who ask.
  BoundedQueue<Task> tasks_{8};
  NetworksView now_;  ///< Of the thread.
  SnapshotSlot<NetworksView> view_;
  std::jthread thread_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
