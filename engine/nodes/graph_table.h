// SPDX-License-Identifier: Apache-2.0
#pragma once

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
};

/// Asks all nodes of a graph at once, and waits for them for `patience_s` at most.
/// @param name  As whom: of its key, where the graph has keys.
Result<std::vector<NodeState>> AskGraph(const GraphPlan& plan, const std::string& name,
                                        double patience_s, const std::stop_token& stop);

/// The graph as a table for people: nodes, whom they ask, rates, latencies, what was dropped,
/// refused and asked again.
std::string GraphInWords(const std::vector<NodeState>& states);
nlohmann::json GraphStateToJson(const std::vector<NodeState>& states);

}  // namespace plumbline
