// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "engine/base/queue.h"
#include "engine/nodes/graph_plan.h"
#include "engine/snapshot/graph_view.h"

namespace plumbline {

/// Who looks on without a name of its own.
inline constexpr const char* kViewerName = "viewer";

/// A running graph, and as whom it is asked.
struct GraphChoice {
  GraphPlan plan;
  std::string name;  ///< The folder or file that it was found by.
  std::string as;    ///< Whose key is used, where the graph has keys.
};

/// Asks the nodes of a graph once a second how they are, on a thread of its own.
class GraphProcess {
 public:
  /// @param on_publish  Called on the thread after every publication (to wake the window).
  GraphProcess(GraphChoice graph, std::function<void()> on_publish);
  ~GraphProcess();
  GraphProcess(const GraphProcess&) = delete;
  GraphProcess& operator=(const GraphProcess&) = delete;

  /// Null before the first answer.
  std::shared_ptr<const GraphView> View() const { return view_.Latest(); }

 private:
  void Run(const std::stop_token& stop);

  const GraphChoice graph_;
  const std::function<void()> on_publish_;
  SnapshotSlot<GraphView> view_;
  std::jthread thread_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
