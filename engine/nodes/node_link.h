// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/nodes/graph_plan.h"
#include "engine/transport/node_client.h"
#include "engine/transport/node_server.h"
#include "engine/transport/wire_values.h"

namespace plumbline {

/// What a node is started with.
struct NodeSetup {
  GraphPlan plan;  ///< Resolved, with a recipe.
  GraphNode node;
  std::string program_version;
  WorkContext work;
};

/// Since 1970, by the clock of this machine.
std::int64_t SystemClockNs();

/// Counts what flows through a node. Safe to use from several threads.
class StreamMeter {
 public:
  explicit StreamMeter(std::string name) : name_(std::move(name)) {}
  void Count(double latency_ms);
  void Drop(int items);
  wire::Stream ToWire() const;

 private:
  using Clock = std::chrono::steady_clock;
  const std::string name_;
  mutable std::mutex mutex_;
  std::uint64_t items_ = 0, dropped_ = 0;
  std::deque<std::pair<Clock::time_point, double>> late_;  ///< When, and its latency.
};

/// The sockets of a node: the one it is asked on, and those on which it asks others. Safe to use
/// from several threads.
class NodeLink {
 public:
  /// Errors: those of sockets and keys, in one sentence.
  static Result<std::unique_ptr<NodeLink>> Open(const NodeSetup& setup);
  ~NodeLink();

  NodeServer& server() { return *server_; }
  const std::shared_ptr<PixelCounts>& pixels() const { return board_->pixels; }
  /// Connects to a node of the graph; lives as long as this.
  Result<NodeClient*> Ask(const std::string& name);

  // For AboutRequests.
  void SetState(const std::string& state);
  void SetChoice(const std::string& json);
  StreamMeter& AddStream(const std::string& name);

  /// Answers a request, or refuses it. kCancelled is not answered: this node ends, and the next one
  /// of its name will be asked again.
  void Answer(const AskedRequest& asked, Result<wire::Reply> reply);
  /// Answers requests in the caller's thread, one after another, until `stop` is requested.
  void Serve(const std::stop_token& stop,
             const std::function<Result<wire::Reply>(const wire::Request&)>& answer);

 private:
  /// What is told of the node, shared with the server's thread.
  struct Board {
    std::shared_ptr<PixelCounts> pixels = std::make_shared<PixelCounts>();
    std::string name, kind, program;
    std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
    std::mutex mutex;
    std::string state, choice;
    std::vector<std::unique_ptr<NodeClient>> peers;
    std::vector<std::unique_ptr<StreamMeter>> streams;

    void Tell(wire::About& about);
  };

  NodeLink() = default;
  GraphPlan plan_;
  std::shared_ptr<SocketContext> context_;
  std::shared_ptr<Board> board_ = std::make_shared<Board>();
  std::unique_ptr<NodeServer> server_;
};

/// The sockets' context of a program that takes part in a graph as `name`: with keys where the
/// graph has any.
Result<std::shared_ptr<SocketContext>> ContextOf(const GraphPlan& plan, const std::string& name);

/// For requests that a node does not answer.
Error DoesNotAnswer(const wire::Request& request, const GraphNode& node);

}  // namespace plumbline
