// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "engine/base/result.h"
#include "engine/transport/endpoint.h"
#include "engine/transport/plumbline.pb.h"
#include "engine/transport/socket_context.h"

namespace plumbline {

/// A request that waits for its answer, and where that goes.
struct AskedRequest {
  std::string peer;  ///< Of the connection, as ZeroMQ names it.
  wire::Request request;
};

struct NodeServerOptions {
  std::size_t most_open = 64;  ///< Requests of one peer that wait; more are refused.
  double most_per_s = 20000;   ///< Requests of one peer; more are refused.
};

/// The socket on which a node is asked. A thread of its own takes requests in, refuses what is no
/// request, of another version, too large or too many, counts all of it, and answers AboutRequests,
/// so that a node that is busy still says how it is. All functions are safe to call from several
/// threads.
class NodeServer {
 public:
  /// @param about  Fills in what it knows of the node; called from the server's thread, must not
  ///        wait.
  /// Errors: kIo where the endpoint is taken or cannot be had; kInvalidInput where others could
  /// reach it and there are no keys.
  static Result<std::unique_ptr<NodeServer>> Listen(std::shared_ptr<SocketContext> context,
                                                    const Endpoint& endpoint,
                                                    std::function<void(wire::About&)> about,
                                                    const NodeServerOptions& options = {});
  /// Requests that wait are not answered.
  ~NodeServer();

  /// Waits for the next request; nothing once `stop` is requested.
  std::optional<AskedRequest> Next(const std::stop_token& stop);
  /// Answers; once for each request. An answer to a peer that is gone is dropped.
  void Answer(const AskedRequest& asked, wire::Reply reply);

 private:
  class Impl;
  explicit NodeServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace plumbline
