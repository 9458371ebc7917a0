// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include <nlohmann/json.hpp>

#include "app/platform/interrupts.h"
#include "app/verbs/graph_arguments.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/nodes/graph_table.h"

namespace plumbline {
namespace {

struct GraphArguments {
  std::string graph, json, dot, name = "viewer";
  double patience_s = 2, watch_s = 0;
};

Status ShowGraph(const GraphArguments& arguments) {
  const Result<GraphPlan> plan = GraphNamed(arguments.graph);
  if (!plan.ok()) return plan.error();
  if (plan->folder.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + arguments.graph +
                     "' is not running; name the folder that 'plumbline up' "
                     "told when it started"};
  }
  std::stop_source stop;
  const Interrupts interrupts([&stop] { stop.request_stop(); });
  const auto watch = GraphWatch::Create(*plan, arguments.name);
  if (!watch.ok()) return watch.error();
  while (true) {
    const auto states = (*watch)->Ask(arguments.patience_s, stop.get_token());
    if (arguments.dot == "-")
      std::printf("%s", GraphAsDot(states).c_str());
    else if (arguments.json != "-")
      std::printf("%s\n", GraphInWords(states).c_str());
    std::fflush(stdout);
    if (!arguments.dot.empty() && arguments.dot != "-") {
      if (Status status = WriteFileAtomically(arguments.dot, GraphAsDot(states)); !status.ok())
        return status;
    }
    if (!arguments.json.empty()) {
      if (Status status = WriteJsonResult(arguments.json, GraphStateToJson(states)); !status.ok())
        return status;
    }
    if (arguments.watch_s <= 0) return {};
    const auto until =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(arguments.watch_s);
    while (std::chrono::steady_clock::now() < until && !stop.stop_requested())
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (stop.stop_requested()) return {};
  }
}

}  // namespace

void AddGraphVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<GraphArguments>();
  CLI::App* verb = app.add_subcommand(
      "graph", "Show a running graph: its nodes, rates, latencies, and what was dropped");
  verb->add_option("graph", arguments->graph, "The folder that 'up' told, or the graph.json in it")
      ->required();
  verb->add_option("--watch", arguments->watch_s, "Again every so many seconds, until Ctrl-C")
      ->check(CLI::Range(0.1, 3600.0));
  verb->add_option("--patience", arguments->patience_s, "Seconds to wait for a node")
      ->check(CLI::Range(0.01, 600.0))
      ->capture_default_str();
  verb->add_option("--as", arguments->name, "Whose key to use, where the graph has keys")
      ->capture_default_str();
  verb->add_option("--dot", arguments->dot,
                   "Draw it: for Graphviz (dot -Tsvg); - for standard output");
  verb->add_option("--json", arguments->json, "Write it here; - for standard output");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return ShowGraph(*arguments); }; });
}

}  // namespace plumbline
