// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the processes of a graph are (docs/processes.md), as the window shows it.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace plumbline {

struct StreamView {
  std::string name;
  std::uint64_t items = 0, dropped = 0;
  double per_s = 0, latency_ms = 0;
};

/// Whom a node asks.
struct PeerView {
  std::string name;
  bool connected = false;
  std::uint64_t requests = 0, open = 0, asked_again = 0;
  double mean_wait_ms = 0;
};

struct NodeView {
  std::string name, kind, endpoint;
  bool answers = false;  ///< If not, what follows is what it said last, if anything.
  std::string state;     ///< In its own words.
  int process = 0;
  double up_s = 0;
  double cores = 0;  ///< Processor time over the last seconds, in cores.
  double resident_mb = 0;
  std::uint64_t requests = 0, waiting = 0, refused = 0;
  int restarts = 0;  ///< Seen while it was watched.
  /// How far the clock of its machine is ahead of ours [ms]; nothing where that is less than what
  /// asking takes.
  std::optional<double> clock_ahead_ms;
  double clock_uncertainty_ms = 0;
  std::vector<StreamView> streams;
  std::vector<PeerView> peers;
};

struct GraphView {
  std::string name;     ///< The folder or file that it was found by.
  std::string problem;  ///< Why it cannot be asked; "": it can.
  std::vector<NodeView> nodes;
};

}  // namespace plumbline
