// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/graph_table.h"

#include <chrono>
#include <cstdio>
#include <future>

#include <nlohmann/json.hpp>

#include "engine/nodes/node_link.h"

namespace plumbline {
namespace {

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

std::string NodeInWords(const NodeState& state) {
  std::string text = Formatted("%-10s %-9s ", state.node.name.c_str(),
                               std::string(NameOf(state.node.kind)).c_str());
  if (!state.about) return text + "does not answer at " + state.node.endpoint + "\n";
  const wire::About& about = *state.about;
  const wire::Served& served = about.served();
  text += Formatted("process %d, up %.0f s, %.0f %% of a core, %.0f MB: %s\n", about.process(),
                    about.up_s(), about.up_s() > 0 ? 100 * about.cpu_s() / about.up_s() : 0,
                    static_cast<double>(about.resident_bytes()) / 1e6, about.state().c_str());
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

Result<std::vector<NodeState>> AskGraph(const GraphPlan& plan, const std::string& name,
                                        double patience_s, const std::stop_token& stop) {
  const Result<std::shared_ptr<SocketContext>> context = ContextOf(plan, name);
  if (!context.ok()) return context.error();
  std::vector<std::unique_ptr<NodeClient>> clients;
  std::vector<std::future<Result<SharedReply>>> replies;
  std::vector<NodeState> states;
  for (const GraphNode& node : plan.nodes) {
    const Result<Endpoint> endpoint = Endpoint::Parse(node.endpoint);
    if (!endpoint.ok()) return endpoint.error();
    auto client = NodeClient::Connect(*context, node.name, *endpoint);
    if (!client.ok()) return client.error();
    wire::Request request;
    request.mutable_about();
    replies.push_back((*client)->Ask(std::move(request)));
    clients.push_back(std::move(client).value());
    states.push_back({node, {}});
  }
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
  for (std::size_t i = 0; i < replies.size(); ++i) {
    while (!stop.stop_requested() && std::chrono::steady_clock::now() < until &&
           replies[i].wait_for(std::chrono::milliseconds(20)) != std::future_status::ready)
      continue;
    if (replies[i].wait_for(std::chrono::seconds(0)) != std::future_status::ready) continue;
    const Result<SharedReply> reply = replies[i].get();
    if (reply.ok() && (*reply)->has_about()) states[i].about = (*reply)->about();
  }
  return states;
}

std::string GraphInWords(const std::vector<NodeState>& states) {
  std::string text;
  for (const NodeState& state : states) text += NodeInWords(state);
  return text;
}

nlohmann::json GraphStateToJson(const std::vector<NodeState>& states) {
  nlohmann::json nodes = nlohmann::json::array();
  for (const NodeState& state : states) nodes.push_back(NodeToJson(state));
  return {{"nodes", std::move(nodes)}};
}

}  // namespace plumbline
