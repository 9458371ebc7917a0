// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/node_link.h"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "engine/transport/message_checks.h"

namespace plumbline {
namespace {

constexpr std::size_t kLateItems = 64;

double CpuSeconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::uint64_t ResidentBytes() {
  std::ifstream pages("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  pages >> all >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

std::int64_t SystemClockNs() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

void StreamMeter::Count(double latency_ms) {
  const std::lock_guard lock(mutex_);
  ++items_;
  late_.emplace_back(Clock::now(), latency_ms);
  if (late_.size() > kLateItems) late_.pop_front();
}

void StreamMeter::Drop(int items) {
  const std::lock_guard lock(mutex_);
  dropped_ += static_cast<std::uint64_t>(items);
}

wire::Stream StreamMeter::ToWire() const {
  const std::lock_guard lock(mutex_);
  wire::Stream stream;
  stream.set_name(name_);
  stream.set_items(items_);
  stream.set_dropped(dropped_);
  if (late_.empty()) return stream;
  double sum = 0;
  for (const auto& [when, latency] : late_) sum += latency;
  stream.set_latency_ms(sum / static_cast<double>(late_.size()));
  const std::chrono::duration<double> span = Clock::now() - late_.front().first;
  if (late_.size() > 1) stream.set_per_s(static_cast<double>(late_.size() - 1) / span.count());
  return stream;
}

void NodeLink::Board::Tell(wire::About& about) {
  about.set_name(name);
  about.set_kind(kind);
  about.set_program(program);
  about.set_process(::getpid());
  about.set_up_s(std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count());
  about.set_cpu_s(CpuSeconds());
  about.set_resident_bytes(ResidentBytes());
  about.set_clock_ns(SystemClockNs());
  wire::Served& served = *about.mutable_served();
  served.set_images_shared(pixels->shared);
  served.set_images_sent(pixels->sent);
  served.set_copied_bytes(pixels->copied_bytes);
  const std::lock_guard lock(mutex);
  about.set_state(state);
  about.set_choice(choice);
  for (const auto& peer : peers) *about.add_peers() = peer->health();
  for (const auto& stream : streams) *about.add_streams() = stream->ToWire();
}

Result<std::shared_ptr<SocketContext>> ContextOf(const GraphPlan& plan, const std::string& name) {
  std::optional<CurveKeys> keys;
  if (!plan.keys.empty()) {
    Result<CurveKeys> read = ReadCurveKeys(plan.keys, name);
    if (!read.ok()) return read.error();
    keys = std::move(read).value();
  }
  return SocketContext::Create(std::move(keys));
}

Result<std::unique_ptr<NodeLink>> NodeLink::Open(const NodeSetup& setup) {
  std::unique_ptr<NodeLink> link(new NodeLink());
  link->plan_ = setup.plan;
  link->board_->name = setup.node.name;
  link->board_->kind = NameOf(setup.node.kind);
  link->board_->program = "plumbline " + setup.program_version;
  link->board_->state = "starting";
  Result<std::shared_ptr<SocketContext>> context = ContextOf(setup.plan, setup.node.name);
  if (!context.ok()) return context.error();
  link->context_ = std::move(context).value();
  const Result<Endpoint> endpoint = Endpoint::Parse(setup.node.endpoint);
  if (!endpoint.ok()) return endpoint.error();
  Result<std::unique_ptr<NodeServer>> server =
      NodeServer::Listen(link->context_, *endpoint,
                         [board = link->board_](wire::About& about) { board->Tell(about); });
  if (!server.ok()) return server.error();
  link->server_ = std::move(server).value();
  return link;
}

NodeLink::~NodeLink() {
  server_.reset();
  const std::lock_guard lock(board_->mutex);
  board_->peers.clear();
}

Result<NodeClient*> NodeLink::Ask(const std::string& name) {
  const GraphNode* node = plan_.Find(name);
  if (node == nullptr) return Error{ErrorCode::kNotFound, "the graph has no node '" + name + "'"};
  const Result<Endpoint> endpoint = Endpoint::Parse(node->endpoint);
  if (!endpoint.ok()) return endpoint.error();
  Result<std::unique_ptr<NodeClient>> client = NodeClient::Connect(context_, name, *endpoint);
  if (!client.ok()) return client.error();
  const std::lock_guard lock(board_->mutex);
  board_->peers.push_back(std::move(client).value());
  return board_->peers.back().get();
}

void NodeLink::SetState(const std::string& state) {
  const std::lock_guard lock(board_->mutex);
  board_->state = state;
}

void NodeLink::SetChoice(const std::string& json) {
  const std::lock_guard lock(board_->mutex);
  board_->choice = json;
}

StreamMeter& NodeLink::AddStream(const std::string& name) {
  const std::lock_guard lock(board_->mutex);
  board_->streams.push_back(std::make_unique<StreamMeter>(name));
  return *board_->streams.back();
}

void NodeLink::Answer(const AskedRequest& asked, Result<wire::Reply> reply) {
  if (!reply.ok() && reply.error().code == ErrorCode::kCancelled) return;
  server_->Answer(asked, reply.ok() ? std::move(reply).value() : RefusalOf(reply.error()));
}

void NodeLink::Serve(const std::stop_token& stop,
                     const std::function<Result<wire::Reply>(const wire::Request&)>& answer) {
  while (const auto asked = server_->Next(stop)) Answer(*asked, answer(asked->request));
}

Error DoesNotAnswer(const wire::Request& request, const GraphNode& node) {
  static constexpr const char* kAsked[] = {"about",  "sequence", "images",  "edges",   "proposals",
                                           "scores", "header",   "reports", "resume",  "map",
                                           "imu",    "poses",    "growth",  "recorded"};
  const int index = static_cast<int>(request.what_case()) - static_cast<int>(wire::Request::kAbout);
  const bool known = index >= 0 && index < static_cast<int>(std::size(kAsked));
  return {ErrorCode::kUnsupported, "the node '" + node.name + "' (" +
                                       std::string(NameOf(node.kind)) + ") does not answer to '" +
                                       (known ? kAsked[index] : "?") + "'"};
}

}  // namespace plumbline
