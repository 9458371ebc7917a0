// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/graph_process.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

#include "engine/nodes/graph_table.h"

namespace plumbline {
namespace {

constexpr auto kPeriod = std::chrono::seconds(1);
constexpr double kPatience_s = 0.8;
/// Over less time than this nothing is said of the processor.
constexpr double kLeastTime_s = 0.5;
/// Clocks that differ by no more than this beyond what asking takes are taken for one.
constexpr double kSameClock_ms = 1;

/// What is kept of a node from one answer to the next.
struct Before {
  NodeView view;
  double cpu_s = 0, up_s = 0;
};

StreamView ViewOf(const wire::Stream& stream) {
  return {stream.name(), stream.items(), stream.dropped(), stream.per_s(), stream.latency_ms()};
}

PeerView ViewOf(const wire::Peer& peer) {
  const std::uint64_t open = peer.requests() - std::min(peer.requests(), peer.replies());
  return {peer.name(), peer.connected(),   peer.requests(),
          open,        peer.asked_again(), peer.mean_wait_ms()};
}

void Take(const NodeState& state, Before& before) {
  NodeView& view = before.view;
  view.name = state.node.name;
  view.kind = NameOf(state.node.kind);
  view.endpoint = state.node.endpoint;
  view.answers = state.about.has_value();
  if (!view.answers) return;
  const wire::About& about = *state.about;
  const bool same = view.process == about.process() && about.up_s() > before.up_s;
  if (view.process != 0 && !same) ++view.restarts;
  const double since_s = about.up_s() - (same ? before.up_s : 0);
  const double used_s = about.cpu_s() - (same ? before.cpu_s : 0);
  view.cores = since_s > kLeastTime_s ? used_s / since_s : 0;
  before.cpu_s = about.cpu_s();
  before.up_s = about.up_s();
  view.process = about.process();
  view.up_s = about.up_s();
  view.state = about.state();
  view.resident_mb = 1e-6 * static_cast<double>(about.resident_bytes());
  const wire::Served& served = about.served();
  view.requests = served.requests();
  view.waiting = served.waiting();
  view.refused = served.refused_malformed() + served.refused_version() + served.refused_size() +
                 served.refused_rate() + served.refused_peers();
  view.clock_ahead_ms.reset();
  if (state.clock &&
      std::abs(state.clock->offset_ms) > state.clock->uncertainty_ms + kSameClock_ms) {
    view.clock_ahead_ms = state.clock->offset_ms;
    view.clock_uncertainty_ms = state.clock->uncertainty_ms;
  }
  view.streams.clear();
  for (const wire::Stream& stream : about.streams()) view.streams.push_back(ViewOf(stream));
  view.peers.clear();
  for (const wire::Peer& peer : about.peers()) view.peers.push_back(ViewOf(peer));
}

}  // namespace

GraphProcess::GraphProcess(GraphChoice graph, std::function<void()> on_publish)
    : graph_(std::move(graph)), on_publish_(std::move(on_publish)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

GraphProcess::~GraphProcess() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void GraphProcess::Run(const std::stop_token& stop) {
  const auto publish = [&](GraphView view) {
    view.name = graph_.name;
    view_.Publish(std::make_shared<const GraphView>(std::move(view)));
    if (on_publish_) on_publish_();
  };
  const auto watch = GraphWatch::Create(graph_.plan, graph_.as);
  if (!watch.ok()) return publish({{}, watch.error().message, {}});
  std::map<std::string, Before> known;
  while (!stop.stop_requested()) {
    const auto until = std::chrono::steady_clock::now() + kPeriod;
    GraphView view;
    for (const NodeState& state : (*watch)->Ask(kPatience_s, stop)) {
      Before& before = known[state.node.name];
      Take(state, before);
      view.nodes.push_back(before.view);
    }
    if (stop.stop_requested()) return;
    publish(std::move(view));
    while (!stop.stop_requested() && std::chrono::steady_clock::now() < until)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

}  // namespace plumbline
