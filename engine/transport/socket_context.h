// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "engine/base/result.h"
#include "engine/transport/curve_keys.h"
#include "engine/transport/endpoint.h"

namespace zmq {
class context_t;
class socket_t;
}  // namespace zmq

namespace plumbline {

/// What all sockets of a program share: ZeroMQ's threads, the keys, and who decides which peers are
/// let in. Safe to use from several threads; outlives the sockets that were made with it.
class SocketContext {
 public:
  /// @param keys  Nothing: only sockets that this machine alone can reach.
  static Result<std::shared_ptr<SocketContext>> Create(std::optional<CurveKeys> keys = {});
  ~SocketContext();

  zmq::context_t& zmq();
  /// Makes a socket fit for being reached at an endpoint: encrypted where there are keys, refused
  /// (kInvalidInput) where others could reach it and there are none.
  Status PrepareToListen(zmq::socket_t& socket, const Endpoint& endpoint);
  /// @param peer  The name of whose key it must have, where there are keys. Errors: kInvalidInput,
  /// kNotFound for a peer without a public key.
  Status PrepareToAsk(zmq::socket_t& socket, const Endpoint& endpoint, const std::string& peer);
  /// Peers that were not let in.
  std::uint64_t refused_peers() const;

 private:
  struct Impl;
  explicit SocketContext(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace plumbline
