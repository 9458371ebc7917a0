// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/socket_context.h"

#include <atomic>
#include <set>
#include <thread>
#include <vector>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include "engine/base/log.h"

namespace plumbline {
namespace {

constexpr const char* kDoor = "inproc://zeromq.zap.01";  // ZeroMQ RFC 27
constexpr std::size_t kKeyBytes = 32;

/// A message that is larger ends the connection before it is held in memory. An image of 4096 x
/// 4096 fits.
constexpr std::int64_t kMostBytes = std::int64_t{64} << 20;

/// How long a closed socket still hands on what was sent. Not 0: libzmq 4.3 then takes the message
/// that it is sending from under itself, and aborts ("session_base.cpp:260") where the connection
/// breaks in that moment, as it does when the processes of a graph end together.
constexpr int kLinger_ms = 100;

void SetCommon(zmq::socket_t& socket) {
  socket.set(zmq::sockopt::linger, kLinger_ms);
  socket.set(zmq::sockopt::maxmsgsize, kMostBytes);
  socket.set(zmq::sockopt::ipv6, true);
  // A peer that is cut off without a word is missed after a few seconds.
  socket.set(zmq::sockopt::heartbeat_ivl, 1000);
  socket.set(zmq::sockopt::heartbeat_timeout, 5000);
  socket.set(zmq::sockopt::heartbeat_ttl, 10000);
}

Error NeedsKeys(const Endpoint& endpoint) {
  return {ErrorCode::kInvalidInput,
          "'" + endpoint.text() +
              "' can be reached from other machines, which needs keys; make them with 'plumbline "
              "keys' and name their folder in the graph (\"keys\")"};
}

}  // namespace

struct SocketContext::Impl {
  zmq::context_t context;
  std::optional<CurveKeys> keys;
  std::set<std::string> known;  ///< Public keys, as bytes.
  std::atomic<std::uint64_t> refused{0};
  std::atomic<bool> ending{false};
  std::thread door;

  ~Impl() {
    ending = true;
    context.shutdown();
    if (door.joinable()) door.join();
  }

  /// Who asks to be let in, and with which key (ZAP).
  void KeepDoor(zmq::socket_t socket) {
    try {
      while (!ending) {
        std::vector<zmq::message_t> asked;
        if (!zmq::recv_multipart(socket, std::back_inserter(asked))) continue;
        if (asked.size() < 6) continue;
        const bool curve = asked[5].to_string_view() == "CURVE" && asked.size() == 7 &&
                           asked[6].size() == kKeyBytes;
        const bool let_in = curve && known.contains(asked[6].to_string());
        if (!let_in && refused++ < 10)
          log::warn("a peer at {} was refused: its key is not known", asked[3].to_string());
        std::vector<zmq::message_t> answer;
        for (const std::string_view part : {std::string_view("1.0"), asked[1].to_string_view(),
                                            std::string_view(let_in ? "200" : "400"),
                                            std::string_view(let_in ? "" : "this key is not known"),
                                            std::string_view(), std::string_view()})
          answer.emplace_back(part.data(), part.size());
        zmq::send_multipart(socket, answer);
      }
    } catch (const zmq::error_t&) {  // the context ends
    }
  }

  Status OpenDoor() {
    for (const auto& [name, text] : keys->public_of) {
      std::string bytes(kKeyBytes, '\0');
      zmq_z85_decode(reinterpret_cast<std::uint8_t*>(bytes.data()), text.c_str());
      known.insert(std::move(bytes));
    }
    zmq::socket_t socket(context, zmq::socket_type::rep);
    socket.set(zmq::sockopt::linger, 0);
    socket.bind(kDoor);
    door = std::thread([this, moved = std::move(socket)]() mutable { KeepDoor(std::move(moved)); });
    return {};
  }
};

SocketContext::SocketContext(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SocketContext::~SocketContext() = default;

Result<std::shared_ptr<SocketContext>> SocketContext::Create(std::optional<CurveKeys> keys) {
  try {
    auto impl = std::make_unique<Impl>();
    impl->keys = std::move(keys);
    if (impl->keys) {
      if (Status status = impl->OpenDoor(); !status.ok()) return status.error();
    }
    return std::shared_ptr<SocketContext>(new SocketContext(std::move(impl)));
  } catch (const zmq::error_t& error) {
    return Error{ErrorCode::kIo, std::string("cannot use ZeroMQ: ") + error.what()};
  }
}

zmq::context_t& SocketContext::zmq() { return impl_->context; }
std::uint64_t SocketContext::refused_peers() const { return impl_->refused; }

Status SocketContext::PrepareToListen(zmq::socket_t& socket, const Endpoint& endpoint) {
  SetCommon(socket);
  if (!impl_->keys) return endpoint.is_local() ? Status() : Status(NeedsKeys(endpoint));
  socket.set(zmq::sockopt::curve_server, true);
  socket.set(zmq::sockopt::curve_secretkey, impl_->keys->own_secret);
  socket.set(zmq::sockopt::zap_domain, "plumbline");
  return {};
}

Status SocketContext::PrepareToAsk(zmq::socket_t& socket, const Endpoint& endpoint,
                                   const std::string& peer) {
  SetCommon(socket);
  socket.set(zmq::sockopt::reconnect_ivl, 20);
  socket.set(zmq::sockopt::reconnect_ivl_max, 500);
  if (!impl_->keys) return endpoint.is_local() ? Status() : Status(NeedsKeys(endpoint));
  const auto found = impl_->keys->public_of.find(peer);
  if (found == impl_->keys->public_of.end()) {
    return Error{ErrorCode::kNotFound, "there is no public key of the node '" + peer + "' (" +
                                           peer +
                                           ".public) in the folder of keys; copy "
                                           "it from where it was made"};
  }
  socket.set(zmq::sockopt::curve_serverkey, found->second);
  socket.set(zmq::sockopt::curve_publickey, impl_->keys->own_public);
  socket.set(zmq::sockopt::curve_secretkey, impl_->keys->own_secret);
  return {};
}

}  // namespace plumbline
