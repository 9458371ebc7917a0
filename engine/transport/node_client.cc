// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/node_client.h"

#include <unistd.h>

#include <chrono>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include "engine/base/log.h"
#include "engine/transport/message_checks.h"
#include "engine/transport/shared_image.h"
#include "engine/transport/wake_signal.h"

namespace plumbline {
namespace {

using ClientClock = std::chrono::steady_clock;

const Error kStopped = {ErrorCode::kCancelled, "stopped"};

/// How long a peer that refused us is left alone. The socket then has no connection and does not
/// seek another one by itself: only where a peer went away does it.
constexpr std::chrono::milliseconds kAfterRefusal(500);

}  // namespace

class NodeClient::Impl {
 public:
  Impl(std::shared_ptr<SocketContext> context, std::string peer, const Endpoint& endpoint)
      : context_(std::move(context)),
        peer_(std::move(peer)),
        endpoint_(endpoint),
        socket_(context_->zmq(), zmq::socket_type::dealer),
        monitor_(context_->zmq(), zmq::socket_type::pair) {}

  ~Impl() {
    thread_.request_stop();
    wake_.Send();
    if (thread_.joinable()) thread_.join();
    for (auto& [id, open] : open_) open.promise.set_value(kStopped);
  }

  Status Connect() {
    try {
      if (Status status = context_->PrepareToAsk(socket_, endpoint_, peer_); !status.ok())
        return status;
      socket_.set(zmq::sockopt::sndhwm, 0);  // what is open is bounded by who asks
      const std::string events = "inproc://events of " + std::to_string(wake_.descriptor());
      if (zmq_socket_monitor(socket_.handle(), events.c_str(),
                             ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED |
                                 ZMQ_EVENT_HANDSHAKE_FAILED_AUTH |
                                 ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL) != 0)
        throw zmq::error_t();
      monitor_.set(zmq::sockopt::linger, 0);
      monitor_.connect(events);
      socket_.connect(endpoint_.text());
    } catch (const zmq::error_t& error) {
      return Error{ErrorCode::kIo, "cannot ask at '" + endpoint_.text() + "': " + error.what()};
    }
    thread_ = std::jthread([this](const std::stop_token& stop) { Work(stop); });
    return {};
  }

  std::future<Result<SharedReply>> Ask(wire::Request request) {
    request.set_version(kWireVersion);
    request.set_machine(ThisMachine());
    std::future<Result<SharedReply>> future;
    {
      const std::lock_guard lock(mutex_);
      const std::uint64_t id = ++last_id_;
      request.set_id(id);
      OpenRequest& open = open_[id];
      future = open.promise.get_future();
      open.bytes = request.SerializeAsString();
      unsent_.push_back(id);
      ++health_.requests;
    }
    wake_.Send();
    return future;
  }

  wire::Peer health() const {
    const std::lock_guard lock(mutex_);
    wire::Peer peer;
    peer.set_name(peer_);
    peer.set_endpoint(endpoint_.text());
    peer.set_connected(health_.connected);
    peer.set_requests(health_.requests);
    peer.set_replies(health_.replies);
    peer.set_asked_again(health_.asked_again);
    peer.set_connections(health_.connections);
    peer.set_bytes_in(health_.bytes_in);
    peer.set_malformed(health_.malformed);
    peer.set_mean_wait_ms(health_.mean_wait_ms);
    return peer;
  }

 private:
  struct OpenRequest {
    std::promise<Result<SharedReply>> promise;
    std::string bytes;
    bool lost = false;  ///< The connection that it was sent over has ended.
    bool sent = false;
    ClientClock::time_point asked = ClientClock::now();
  };

  void Work(const std::stop_token& stop) {
    try {
      while (!stop.stop_requested()) {
        const bool can_send = SendUnsent();
        const auto events = static_cast<short>(can_send ? ZMQ_POLLIN : ZMQ_POLLIN | ZMQ_POLLOUT);
        zmq::pollitem_t items[] = {{socket_.handle(), 0, events, 0},
                                   {monitor_.handle(), 0, ZMQ_POLLIN, 0},
                                   {nullptr, wake_.descriptor(), ZMQ_POLLIN, 0}};
        zmq::poll(items, 3, std::chrono::milliseconds(500));
        if ((items[2].revents & ZMQ_POLLIN) != 0) wake_.Take();
        TakeReplies();
        TakeEvents();
        KnockAgain();
      }
    } catch (const zmq::error_t& error) {
      if (error.num() != ETERM) log::error("asking '{}' has ended: {}", peer_, error.what());
    }
    // Closed here, in the thread that used them.
    socket_.close();
    monitor_.close();
  }

  /// Whether all was sent. Never waits: without a connection it would wait for ever, and this
  /// thread could not be stopped.
  bool SendUnsent() {
    while (true) {
      std::string bytes;
      {
        const std::lock_guard lock(mutex_);
        while (!unsent_.empty() && !open_.contains(unsent_.front())) unsent_.pop_front();
        if (unsent_.empty()) return true;
        bytes = open_.at(unsent_.front()).bytes;
      }
      const auto flags = zmq::send_flags::dontwait;
      if (!socket_.send(zmq::const_buffer(), zmq::send_flags::sndmore | flags) ||
          !socket_.send(zmq::buffer(bytes), flags))
        return false;
      const std::lock_guard lock(mutex_);
      OpenRequest& open = open_.at(unsent_.front());
      open.sent = true;
      open.lost = false;
      unsent_.pop_front();
    }
  }

  /// Connects again to who refused us: it may know our key by now.
  void KnockAgain() {
    if (!refused_at_ || ClientClock::now() < *refused_at_ + kAfterRefusal) return;
    refused_at_.reset();
    {
      const std::lock_guard lock(mutex_);
      for (auto& [id, open] : open_) open.lost = open.sent;
    }
    // A dealer that has this endpoint in its list, dead or not, does not connect to it again.
    zmq_disconnect(socket_.handle(), endpoint_.text().c_str());
    socket_.connect(endpoint_.text());
  }

  void TakeReplies() {
    while (true) {
      std::vector<zmq::message_t> parts;
      if (!zmq::recv_multipart(socket_, std::back_inserter(parts), zmq::recv_flags::dontwait))
        return;
      if (parts.empty()) return;
      auto reply = ParseReply(parts.back().to_string_view());
      std::optional<OpenRequest> open;
      {
        const std::lock_guard lock(mutex_);
        health_.bytes_in += parts.back().size();
        if (!reply.ok()) {
          if (health_.malformed++ < 3) log::warn("'{}': {}", peer_, reply.error().message);
          if (reply.error().code != ErrorCode::kUnsupported) continue;
          FailAll(reply.error());
          continue;
        }
        const auto found = open_.find(reply->id());
        if (found == open_.end()) continue;  // answered twice
        open = std::move(found->second);
        open_.erase(found);
        ++health_.replies;
        const double waited =
            std::chrono::duration<double, std::milli>(ClientClock::now() - open->asked).count();
        health_.mean_wait_ms += (waited - health_.mean_wait_ms) /
                                static_cast<double>(std::min<std::uint64_t>(health_.replies, 100));
      }
      if (reply->has_refusal()) {
        open->promise.set_value(ErrorOf(reply->refusal()));
      } else {
        open->promise.set_value(std::make_shared<const wire::Reply>(std::move(reply).value()));
      }
    }
  }

  /// A node of another version understands nothing; it would be waited for in vain.
  void FailAll(const Error& error) {
    for (auto& [id, open] : open_)
      open.promise.set_value(Error{error.code, "'" + peer_ + "': " + error.message});
    open_.clear();
    unsent_.clear();
  }

  void TakeEvents() {
    while (true) {
      std::vector<zmq::message_t> parts;
      if (!zmq::recv_multipart(monitor_, std::back_inserter(parts), zmq::recv_flags::dontwait))
        return;
      if (parts.empty() || parts.front().size() < sizeof(std::uint16_t)) return;
      std::uint16_t event = 0;
      std::memcpy(&event, parts.front().data(), sizeof(event));
      const std::lock_guard lock(mutex_);
      if (event == ZMQ_EVENT_DISCONNECTED) {
        health_.connected = false;
        for (auto& [id, open] : open_) open.lost = open.sent;
      } else if (event == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
        health_.connected = true;
        ++health_.connections;
        refused_at_.reset();
        for (auto& [id, open] : open_) {
          if (!open.lost) continue;
          unsent_.push_back(id);
          ++health_.asked_again;
        }
      } else {
        if (!refused_at_) refused_at_ = ClientClock::now();
        if (health_.refused++ > 0) continue;
        if (event == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) {
          log::error("'{}' at {} does not know our key", peer_, endpoint_.text());
        } else {
          log::error("'{}' at {} refuses us; both sides need keys, or neither", peer_,
                     endpoint_.text());
        }
      }
    }
  }

  struct Health {
    bool connected = false;
    std::uint64_t requests = 0, replies = 0, asked_again = 0, connections = 0, bytes_in = 0,
                  malformed = 0, refused = 0;
    double mean_wait_ms = 0;
  };

  const std::shared_ptr<SocketContext> context_;
  const std::string peer_;
  const Endpoint endpoint_;
  const WakeSignal wake_;
  // Of the thread alone once that runs:
  zmq::socket_t socket_, monitor_;
  std::optional<ClientClock::time_point> refused_at_;

  mutable std::mutex mutex_;  ///< Of what follows.
  std::uint64_t last_id_ = 0;
  std::map<std::uint64_t, OpenRequest> open_;
  std::deque<std::uint64_t> unsent_;
  Health health_;
  std::jthread thread_;
};

NodeClient::NodeClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
NodeClient::~NodeClient() = default;

Result<std::unique_ptr<NodeClient>> NodeClient::Connect(std::shared_ptr<SocketContext> context,
                                                        const std::string& peer,
                                                        const Endpoint& endpoint) {
  try {
    auto impl = std::make_unique<Impl>(std::move(context), peer, endpoint);
    if (Status status = impl->Connect(); !status.ok()) return status.error();
    return std::unique_ptr<NodeClient>(new NodeClient(std::move(impl)));
  } catch (const zmq::error_t& error) {
    return Error{ErrorCode::kIo, std::string("cannot make a socket: ") + error.what()};
  }
}

std::future<Result<SharedReply>> NodeClient::Ask(wire::Request request) {
  return impl_->Ask(std::move(request));
}

Result<SharedReply> NodeClient::AskAndWait(wire::Request request, const std::stop_token& stop) {
  auto reply = Ask(std::move(request));
  return WaitFor(reply, stop);
}

wire::Peer NodeClient::health() const { return impl_->health(); }

Result<SharedReply> WaitFor(std::future<Result<SharedReply>>& reply, const std::stop_token& stop) {
  while (reply.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
    if (stop.stop_requested()) return kStopped;
  }
  return reply.get();
}

}  // namespace plumbline
