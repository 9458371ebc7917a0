// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <future>
#include <memory>
#include <stop_token>
#include <string>

#include "engine/base/result.h"
#include "engine/transport/endpoint.h"
#include "engine/transport/plumbline.pb.h"
#include "engine/transport/socket_context.h"

namespace plumbline {

using SharedReply = std::shared_ptr<const wire::Reply>;

/// Asks one node. Where that is not there (yet, or any more), requests wait for it; those that it
/// died over are asked again when it is back. Nothing times out: a graph waits for its parts, and
/// whoever asks may stop waiting. All functions are safe to call from several threads.
class NodeClient {
 public:
  /// @param peer  The node's name: for messages, and of its key.
  /// Errors: kInvalidInput for an endpoint of another machine without keys; kNotFound for a key
  /// that is missing.
  static Result<std::unique_ptr<NodeClient>> Connect(std::shared_ptr<SocketContext> context,
                                                     const std::string& peer,
                                                     const Endpoint& endpoint);
  /// Whoever waits gets kCancelled.
  ~NodeClient();

  /// Asks; id, version and machine are filled in. The future has the reply, or as errors what the
  /// node refused and kCancelled once this ends.
  std::future<Result<SharedReply>> Ask(wire::Request request);
  /// The same, and waits. Errors: also kCancelled once `stop` is requested.
  Result<SharedReply> AskAndWait(wire::Request request, const std::stop_token& stop);

  /// How it fares, for AboutRequests.
  wire::Peer health() const;

 private:
  class Impl;
  explicit NodeClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Waits for a future in small steps. Errors: kCancelled once `stop` is requested.
Result<SharedReply> WaitFor(std::future<Result<SharedReply>>& reply, const std::stop_token& stop);

}  // namespace plumbline
