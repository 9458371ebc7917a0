// SPDX-License-Identifier: Apache-2.0
#include "engine/transport/node_server.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <limits>
#include <map>
#include <mutex>
#include <set>
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

using ServerClock = std::chrono::steady_clock;

constexpr std::size_t kMostPeers = 256;

/// Requests of one connection.
struct PeerLoad {
  std::set<std::uint64_t> open;
  double tokens =
      std::numeric_limits<double>::max();  ///< Of a bucket that holds those of a second.
  ServerClock::time_point filled = ServerClock::now();
  ServerClock::time_point heard = ServerClock::now();

  bool Take(double most_per_s) {
    heard = ServerClock::now();
    tokens = std::min(most_per_s,
                      tokens + most_per_s * std::chrono::duration<double>(heard - filled).count());
    filled = heard;
    if (tokens < 1) return false;
    tokens -= 1;
    return true;
  }
};

}  // namespace

class NodeServer::Impl {
 public:
  Impl(std::shared_ptr<SocketContext> context, std::function<void(wire::About&)> about,
       const NodeServerOptions& options)
      : context_(std::move(context)),
        about_(std::move(about)),
        options_(options),
        socket_(context_->zmq(), zmq::socket_type::router) {}

  ~Impl() {
    thread_.request_stop();
    wake_.Send();
    if (thread_.joinable()) thread_.join();
  }

  Status Listen(const Endpoint& endpoint) {
    try {
      if (Status status = context_->PrepareToListen(socket_, endpoint); !status.ok()) return status;
      // What a peer that does not read may leave here is bounded by what it may ask for.
      socket_.set(zmq::sockopt::sndhwm, static_cast<int>(options_.most_open) * 2);
      socket_.bind(endpoint.text());
    } catch (const zmq::error_t& error) {
      return Error{ErrorCode::kIo, "cannot listen at '" + endpoint.text() + "' (" + error.what() +
                                       "); end whoever does, or choose another endpoint"};
    }
    thread_ = std::jthread([this](const std::stop_token& stop) { Serve(stop); });
    return {};
  }

  std::optional<AskedRequest> Next(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    if (!asked_some_.wait(lock, stop, [&] { return !asked_.empty(); })) return std::nullopt;
    AskedRequest asked = std::move(asked_.front());
    asked_.pop_front();
    return asked;
  }

  void Answer(const AskedRequest& asked, wire::Reply reply) {
    reply.set_version(kWireVersion);
    reply.set_id(asked.request.id());
    reply.set_machine(ThisMachine());
    std::string bytes = reply.SerializeAsString();
    {
      const std::lock_guard lock(mutex_);
      answers_.push_back({asked.peer, asked.request.id(), std::move(bytes)});
    }
    wake_.Send();
  }

 private:
  struct AnswerBytes {
    std::string peer;
    std::uint64_t id;
    std::string bytes;
  };

  void Serve(const std::stop_token& stop) {
    try {
      while (!stop.stop_requested()) {
        zmq::pollitem_t items[] = {{socket_.handle(), 0, ZMQ_POLLIN, 0},
                                   {nullptr, wake_.descriptor(), ZMQ_POLLIN, 0}};
        zmq::poll(items, 2, std::chrono::milliseconds(500));
        if ((items[1].revents & ZMQ_POLLIN) != 0) wake_.Take();
        SendAnswers();
        if ((items[0].revents & ZMQ_POLLIN) != 0) TakeRequests();
      }
      SendAnswers();
    } catch (const zmq::error_t& error) {
      if (error.num() != ETERM) log::error("a socket cannot be used any more: {}", error.what());
    }
  }

  void SendAnswers() {
    std::deque<AnswerBytes> answers;
    {
      const std::lock_guard lock(mutex_);
      answers.swap(answers_);
    }
    for (const AnswerBytes& answer : answers) {
      if (const auto load = peers_.find(answer.peer); load != peers_.end())
        load->second.open.erase(answer.id);
      Send(answer.peer, answer.bytes);
    }
  }

  void Send(const std::string& peer, const std::string& bytes) {
    const zmq::const_buffer parts[] = {zmq::buffer(peer), zmq::const_buffer(), zmq::buffer(bytes)};
    // To a peer that is gone or does not read: dropped; it asks again when it is back.
    socket_.send(parts[0], zmq::send_flags::sndmore | zmq::send_flags::dontwait);
    socket_.send(parts[1], zmq::send_flags::sndmore | zmq::send_flags::dontwait);
    socket_.send(parts[2], zmq::send_flags::dontwait);
    ++served_.replies;
    served_.bytes_out += bytes.size();
  }

  void TakeRequests() {
    // Not for ever: answers wait.
    for (int i = 0; i < 100; ++i) {
      std::vector<zmq::message_t> parts;
      if (!zmq::recv_multipart(socket_, std::back_inserter(parts), zmq::recv_flags::dontwait))
        return;
      if (parts.empty()) return;
      const std::string peer = parts.front().to_string();
      for (const zmq::message_t& part : parts) served_.bytes_in += part.size();
      if (parts.size() != 3 || parts[1].size() != 0) {
        ++served_.malformed;
        SendRefusal(peer, 0,
                    {ErrorCode::kCorrupt,
                     "a message of other parts than an empty one and a Request was sent"});
        continue;
      }
      Take(peer, parts[2].to_string_view());
    }
  }

  void Take(const std::string& peer, std::string_view bytes) {
    ++served_.requests;
    ParsedRequest parsed = ParseRequest(bytes);
    if (parsed.fault != MessageFault::kNone) {
      ++(parsed.fault == MessageFault::kVersion ? served_.version
         : parsed.fault == MessageFault::kSize  ? served_.size
                                                : served_.malformed);
      const bool other = parsed.fault == MessageFault::kVersion;
      SendRefusal(peer, parsed.request.id(),
                  {other ? ErrorCode::kUnsupported : ErrorCode::kCorrupt, parsed.sentence});
      return;
    }
    const std::uint64_t id = parsed.request.id();
    Forget();
    PeerLoad& load = peers_[peer];
    const bool fast = !load.Take(options_.most_per_s);
    if (load.open.contains(id)) return;  // asked again: it is at work
    if (fast || load.open.size() >= options_.most_open) {
      ++served_.rate;
      SendRefusal(peer, id,
                  {ErrorCode::kInvalidInput,
                   "too many requests: a peer may have " + std::to_string(options_.most_open) +
                       " open and ask " + std::to_string(static_cast<int>(options_.most_per_s)) +
                       " a second"});
      return;
    }
    if (parsed.request.has_about()) {
      SendAbout(peer, id);
      return;
    }
    load.open.insert(id);
    {
      const std::lock_guard lock(mutex_);
      asked_.push_back({peer, std::move(parsed.request)});
    }
    asked_some_.notify_one();
  }

  /// Connections that nobody was heard of for long.
  void Forget() {
    if (peers_.size() < kMostPeers) return;
    const auto now = ServerClock::now();
    std::erase_if(peers_, [&](const auto& entry) {
      return now - entry.second.heard > std::chrono::seconds(60);
    });
  }

  void SendRefusal(const std::string& peer, std::uint64_t id, const Error& error) {
    wire::Reply reply = RefusalOf(error);
    reply.set_version(kWireVersion);
    reply.set_id(id);
    Send(peer, reply.SerializeAsString());
  }

  void SendAbout(const std::string& peer, std::uint64_t id) {
    wire::Reply reply;
    reply.set_version(kWireVersion);
    reply.set_id(id);
    reply.set_machine(ThisMachine());
    about_(*reply.mutable_about());
    wire::Served& served = *reply.mutable_about()->mutable_served();
    served.set_requests(served_.requests);
    served.set_replies(served_.replies);
    served.set_bytes_in(served_.bytes_in);
    served.set_bytes_out(served_.bytes_out);
    served.set_refused_malformed(served_.malformed);
    served.set_refused_version(served_.version);
    served.set_refused_size(served_.size);
    served.set_refused_rate(served_.rate);
    served.set_refused_peers(context_->refused_peers());
    {
      const std::lock_guard lock(mutex_);
      served.set_waiting(static_cast<std::uint32_t>(asked_.size()));
    }
    Send(peer, reply.SerializeAsString());
  }

  /// Of the thread alone.
  struct Counts {
    std::uint64_t requests = 0, replies = 0, bytes_in = 0, bytes_out = 0, malformed = 0,
                  version = 0, size = 0, rate = 0;
  };

  const std::shared_ptr<SocketContext> context_;
  const std::function<void(wire::About&)> about_;
  const NodeServerOptions options_;
  const WakeSignal wake_;
  zmq::socket_t socket_;  ///< Of the thread alone once that runs.
  Counts served_;
  std::map<std::string, PeerLoad> peers_;

  std::mutex mutex_;
  std::condition_variable_any asked_some_;
  std::deque<AskedRequest> asked_;
  std::deque<AnswerBytes> answers_;
  std::jthread thread_;
};

NodeServer::NodeServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
NodeServer::~NodeServer() = default;

Result<std::unique_ptr<NodeServer>> NodeServer::Listen(std::shared_ptr<SocketContext> context,
                                                       const Endpoint& endpoint,
                                                       std::function<void(wire::About&)> about,
                                                       const NodeServerOptions& options) {
  try {
    auto impl = std::make_unique<Impl>(std::move(context), std::move(about), options);
    if (Status status = impl->Listen(endpoint); !status.ok()) return status.error();
    return std::unique_ptr<NodeServer>(new NodeServer(std::move(impl)));
  } catch (const zmq::error_t& error) {
    return Error{ErrorCode::kIo, std::string("cannot make a socket: ") + error.what()};
  }
}

std::optional<AskedRequest> NodeServer::Next(const std::stop_token& stop) {
  return impl_->Next(stop);
}
void NodeServer::Answer(const AskedRequest& asked, wire::Reply reply) {
  impl_->Answer(asked, std::move(reply));
}

}  // namespace plumbline
