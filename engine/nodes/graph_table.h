// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/result.h"
#include "engine/nodes/graph_plan.h"
#include "engine/transport/plumbline.pb.h"

namespace plumbline {

/// How a node is, as it says; nothing where it does not answer.
struct NodeState {
  GraphNode node;
  std::optional<wire::About> about;
  /// How far the clock of its machine is ahead of ours [ms], and by how much that may be wrong:
  /// half of the time that question and answer took. Nothing where the node does not tell its
  /// clock.
  struct ClockOffset {
    double offset_ms = 0, uncertainty_ms = 0;
  };
  std::optional<ClockOffset> clock;
};

/// Asks the nodes of a graph how they are. Use it in one thread.
class GraphWatch {
 public:
  /// @param name  As whom: of its key, where the graph has keys.
  /// Errors: those of keys and endpoints.
  static Result<std::unique_ptr<GraphWatch>> Create(const GraphPlan& plan, const std::string& name);
  ~GraphWatch();

  /// All at once, waiting for `patience_s` at most. A node that has not answered by then is not
  /// asked again before it has.
  std::vector<NodeState> Ask(double patience_s, const std::stop_token& stop);

 private:
  struct Asked;
  GraphWatch() = default;
  std::vector<std::unique_ptr<Asked>> nodes_;
};

/// The graph as a table for people: nodes, whom they ask, rates, latencies, what was dropped,
/// refused and asked again.
std::string GraphInWords(const std::vector<NodeState>& states);
/// The graph as a drawing of Graphviz: an arrow from each node to who asks it, as data flows.
std::string GraphAsDot(const std::vector<NodeState>& states);
nlohmann::json GraphStateToJson(const std::vector<NodeState>& states);

}  // namespace plumbline
