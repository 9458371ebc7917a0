// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <thread>

#include "engine/base/queue.h"
#include "engine/recording/run_header.h"
#include "engine/snapshot/comparison_view.h"
#include "engine/snapshot/playback_view.h"

namespace plumbline {

struct MapSnapshot;

/// What is compared: what two processes have published.
struct ComparedRun {
  std::shared_ptr<const MapSnapshot> snapshot;   ///< Never null.
  std::shared_ptr<const PlaybackView> playback;  ///< Never null.
  std::shared_ptr<const RunHeader> header;       ///< Null: settings are not compared.
  bool operator==(const ComparedRun&) const = default;
};
struct ComparisonInput {
  ComparedRun first, other;
  Eigen::Vector3d up_in_world{0, 0, 1};
};

/// Compares two runs on a thread of its own, the newest input only.
class ComparisonProcess {
 public:
  /// @param on_publish  Called on the thread after every publication (to wake the window).
  explicit ComparisonProcess(std::function<void()> on_publish);
  ~ComparisonProcess();
  ComparisonProcess(const ComparisonProcess&) = delete;
  ComparisonProcess& operator=(const ComparisonProcess&) = delete;

  /// Returns at once.
  void Post(ComparisonInput input);
  /// Null before the first.
  std::shared_ptr<const ComparisonView> View() const { return view_.Latest(); }

 private:
  void Run();
  void Compare(const ComparisonInput& now, const ComparisonInput* before, ComparisonView& view);

  std::function<void()> on_publish_;
  SnapshotSlot<ComparisonInput> input_;
  BoundedQueue<bool> posted_{1};
  SnapshotSlot<ComparisonView> view_;
  std::jthread thread_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
