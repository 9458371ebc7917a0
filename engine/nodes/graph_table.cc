// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/graph_table.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <future>
#include <thread>

#include <nlohmann/json.hpp>

#include "engine/nodes/node_link.h"

namespace plumbline {
namespace {

/// Clocks that differ by no more than this are taken for one.
constexpr double kSameClock_ms = 1;

template <typename... Arguments>
std::string Formatted(const char* format, Arguments... arguments) {
  char text[400];
  std::snprintf(text, sizeof(text), format, arguments...);
  return text;
}

std::uint64_t Refused(const wire::Served& served) {
  return served.refused_malformed() + served.refused_version() + served.refused_size() +
         served.refused_rate() + served.refused_peers();
}

/// For Graphviz; what a node says of itself may be anything.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '\n') {
      quoted += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string NodeInWords(const NodeState& state) {
  std::string text = Formatted("%-10s %-9s ", state.node.name.c_str(),
                               std::string(NameOf(state.node.kind)).c_str());
  if (!state.about) return text + "does not answer at " + state.node.endpoint + "\n";
  const wire::About& about = *state.about;
  const wire::Served& served = about.served();
  text += Formatted("process %d, up %.0f s, %.0f %% of a core, %.0f MB: %s\n", about.process(),
                    about.up_s(), about.up_s() > 0 ? 100 * about.cpu_s() / about.up_s() : 0,
                    static_cast<double>(about.resident_bytes()) / 1e6, about.state().c_str());
  if (state.clock && std::abs(state.clock->offset_ms) > state.clock->uncertainty_ms + kSameClock_ms)
    text += Formatted("             its clock is %.1f ms %s, within %.1f ms\n",
                      std::abs(state.clock->offset_ms),
                      state.clock->offset_ms > 0 ? "ahead" : "behind", state.clock->uncertainty_ms);
  for (const wire::Stream& stream : about.streams())
    text += Formatted("             %-10s %6llu, %6.1f /s, %7.1f ms, %llu dropped\n",
                      stream.name().c_str(), static_cast<unsigned long long>(stream.items()),
                      stream.per_s(), stream.latency_ms(),
                      static_cast<unsigned long long>(stream.dropped()));
  for (const wire::Peer& peer : about.peers())
    text += Formatted(
        "             asks %-10s %6llu requests, waits %.1f ms, %.1f MB%s%s\n", peer.name().c_str(),
        static_cast<unsigned long long>(peer.requests()), peer.mean_wait_ms(),
        static_cast<double>(peer.bytes_in()) / 1e6,
        peer.asked_again() > 0
            ? Formatted(", %llu asked again", static_cast<unsigned long long>(peer.asked_again()))
                  .c_str()
            : "",
        peer.connected() ? "" : ", NOT CONNECTED");
  text += Formatted("             answered %llu of %llu, %u wait",
                    static_cast<unsigned long long>(served.replies()),
                    static_cast<unsigned long long>(served.requests()), served.waiting());
  if (served.images_shared() + served.images_sent() > 0)
    text += Formatted("; images: %llu shared, %llu sent, %.1f MB copied",
                      static_cast<unsigned long long>(served.images_shared()),
                      static_cast<unsigned long long>(served.images_sent()),
                      static_cast<double>(served.copied_bytes()) / 1e6);
  if (Refused(served) > 0)
    text += Formatted("; REFUSED %llu", static_cast<unsigned long long>(Refused(served)));
  return text + "\n";
}

nlohmann::json NodeToJson(const NodeState& state) {
  nlohmann::json json = {{"name", state.node.name},
                         {"kind", NameOf(state.node.kind)},
                         {"endpoint", state.node.endpoint},
                         {"answers", state.about.has_value()}};
  if (!state.about) return json;
  const wire::About& about = *state.about;
  const wire::Served& served = about.served();
  json["process"] = about.process();
  json["program"] = about.program();
  json["up_s"] = about.up_s();
  json["cpu_s"] = about.cpu_s();
  json["resident_bytes"] = about.resident_bytes();
  json["state"] = about.state();
  if (state.clock)
    json["clock"] = {{"offset_ms", state.clock->offset_ms},
                     {"uncertainty_ms", state.clock->uncertainty_ms}};
  json["served"] = {{"requests", served.requests()},
                    {"replies", served.replies()},
                    {"bytes_in", served.bytes_in()},
                    {"bytes_out", served.bytes_out()},
                    {"waiting", served.waiting()},
                    {"images_shared", served.images_shared()},
                    {"images_sent", served.images_sent()},
                    {"copied_bytes", served.copied_bytes()},
                    {"refused",
                     {{"malformed", served.refused_malformed()},
                      {"version", served.refused_version()},
                      {"size", served.refused_size()},
                      {"rate", served.refused_rate()},
                      {"peers", served.refused_peers()}}}};
  json["streams"] = nlohmann::json::array();
  for (const wire::Stream& stream : about.streams())
    json["streams"].push_back({{"name", stream.name()},
                               {"items", stream.items()},
                               {"dropped", stream.dropped()},
                               {"per_s", stream.per_s()},
                               {"latency_ms", stream.latency_ms()}});
  json["peers"] = nlohmann::json::array();
  for (const wire::Peer& peer : about.peers())
    json["peers"].push_back({{"name", peer.name()},
                             {"endpoint", peer.endpoint()},
                             {"connected", peer.connected()},
                             {"requests", peer.requests()},
                             {"replies", peer.replies()},
                             {"asked_again", peer.asked_again()},
                             {"connections", peer.connections()},
                             {"bytes_in", peer.bytes_in()},
                             {"malformed", peer.malformed()},
                             {"mean_wait_ms", peer.mean_wait_ms()}});
  return json;
}

}  // namespace

struct GraphWatch::Asked {
  GraphNode node;
  std::unique_ptr<NodeClient> client;
  std::future<Result<SharedReply>> reply;  ///< Valid while a question is open.
  std::int64_t asked_ns = 0;
};

Result<std::unique_ptr<GraphWatch>> GraphWatch::Create(const GraphPlan& plan,
                                                       const std::string& name) {
  const Result<std::shared_ptr<SocketContext>> context = ContextOf(plan, name);
  if (!context.ok()) return context.error();
  std::unique_ptr<GraphWatch> watch(new GraphWatch());
  for (const GraphNode& node : plan.nodes) {
    const Result<Endpoint> endpoint = Endpoint::Parse(node.endpoint);
    if (!endpoint.ok()) return endpoint.error();
    auto client = NodeClient::Connect(*context, node.name, *endpoint);
    if (!client.ok()) return client.error();
    auto asked = std::make_unique<Asked>();
    asked->node = node;
    asked->client = std::move(client).value();
    watch->nodes_.push_back(std::move(asked));
  }
  return watch;
}

GraphWatch::~GraphWatch() = default;

std::vector<NodeState> GraphWatch::Ask(double patience_s, const std::stop_token& stop) {
  std::vector<NodeState> states;
  for (const auto& asked : nodes_) {
    states.push_back({asked->node, {}, {}});
    if (asked->reply.valid()) continue;
    wire::Request request;
    request.mutable_about();
    asked->asked_ns = SystemClockNs();
    asked->reply = asked->client->Ask(std::move(request));
  }
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
  bool all = false;
  while (!all && !stop.stop_requested() && std::chrono::steady_clock::now() < until) {
    all = true;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      Asked& asked = *nodes_[i];
      if (!asked.reply.valid()) continue;
      if (asked.reply.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
        all = false;
        continue;
      }
      const Result<SharedReply> reply = asked.reply.get();
      if (!reply.ok() || !(*reply)->has_about()) continue;
      states[i].about = (*reply)->about();
      if (states[i].about->clock_ns() == 0) continue;
      const std::int64_t now_ns = SystemClockNs(), took_ns = now_ns - asked.asked_ns;
      const std::int64_t ahead_ns = states[i].about->clock_ns() - (asked.asked_ns + took_ns / 2);
      states[i].clock = NodeState::ClockOffset{1e-6 * static_cast<double>(ahead_ns),
                                               0.5e-6 * static_cast<double>(took_ns)};
    }
    if (!all) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return states;
}

std::string GraphInWords(const std::vector<NodeState>& states) {
  std::string text;
  for (const NodeState& state : states) text += NodeInWords(state);
  return text;
}

std::string GraphAsDot(const std::vector<NodeState>& states) {
  std::string text =
      "digraph plumbline {\n  rankdir=LR;\n"
      "  node [shape=box, style=\"rounded,filled\", fillcolor=white, fontname=\"sans-serif\"];\n"
      "  edge [fontname=\"sans-serif\", fontsize=10];\n";
  for (const NodeState& state : states) {
    std::string label = state.node.name;
    if (!state.about) {
      label += "\ndoes not answer";
    } else {
      label += "\n" + state.about->state();
      for (const wire::Stream& stream : state.about->streams())
        label +=
            Formatted("\n%s %.1f /s, %.0f ms, %llu dropped", stream.name().c_str(), stream.per_s(),
                      stream.latency_ms(), static_cast<unsigned long long>(stream.dropped()));
    }
    text += "  " + Quoted(state.node.name) + " [label=" + Quoted(label) +
            (state.about ? "" : ", fillcolor=\"#ffd0c8\"") + "];\n";
  }
  for (const NodeState& state : states) {
    if (!state.about) continue;
    for (const wire::Peer& peer : state.about->peers())
      text += "  " + Quoted(peer.name()) + " -> " + Quoted(state.node.name) + " [label=" +
              Quoted(Formatted("%llu, %.1f ms", static_cast<unsigned long long>(peer.replies()),
                               peer.mean_wait_ms())) +
              (peer.connected() ? "" : ", style=dashed") + "];\n";
  }
  return text + "}\n";
}

nlohmann::json GraphStateToJson(const std::vector<NodeState>& states) {
  nlohmann::json nodes = nlohmann::json::array();
  for (const NodeState& state : states) nodes.push_back(NodeToJson(state));
  return {{"nodes", std::move(nodes)}};
}

}  // namespace plumbline
