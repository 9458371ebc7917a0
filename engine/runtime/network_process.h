// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/base/queue.h"
#include "engine/base/worker.h"
#include "engine/snapshot/networks_view.h"
#include "engine/vision/fetched_networks.h"

namespace plumbline {

/// Says which networks there are and what a file of the user's is, and fetches listed ones, on two
/// threads of its own: a long download keeps nobody from looking at a file.
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
  void LookForFetched();
  void Examine(const std::string& file);
  void Download(const ListedNetwork& network, const std::stop_token& stop);
  /// Changes what is known, and publishes it.
  void Change(const std::function<void(NetworksView&)>& change);
  void ChangeDetector(const std::string& name, const std::function<void(ListedDetector&)>& change);

  std::function<void()> on_publish_;
  const std::vector<ListedNetwork> listed_;
  std::stop_source stop_fetching_;  ///< Of those who ask.
  std::mutex mutex_;
  NetworksView now_;  ///< Guarded by it.
  SnapshotSlot<NetworksView> view_;
  Worker looking_, fetching_;  ///< Last: they use all of the above.
};

}  // namespace plumbline
