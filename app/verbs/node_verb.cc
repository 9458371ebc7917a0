// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string>

#include "app/platform/interrupts.h"
#include "app/verbs/verb.h"
#include "engine/nodes/our_nodes.h"

namespace plumbline {
namespace {

struct NodeArguments {
  std::string kind, graph, name;
};

Status RunOneNode(const NodeArguments& arguments) {
  Result<GraphPlan> plan = ReadGraph(arguments.graph);
  if (!plan.ok()) return plan.error();
  if (!plan->recipe || plan->folder.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + arguments.graph +
                     "' does not say what is run; 'plumbline up' writes one that does (graph.json "
                     "in the folder that it tells)"};
  }
  NodeSetup setup;
  for (const GraphNode& node : plan->nodes) {
    const bool meant =
        arguments.name.empty() ? NameOf(node.kind) == arguments.kind : node.name == arguments.name;
    if (meant && NameOf(node.kind) == arguments.kind && setup.node.name.empty()) setup.node = node;
  }
  if (setup.node.name.empty()) {
    return Error{ErrorCode::kNotFound,
                 "'" + arguments.graph + "' has no " + arguments.kind +
                     (arguments.name.empty() ? "" : " '" + arguments.name + "'")};
  }
  setup.plan = std::move(plan).value();
  setup.program_version = PLUMBLINE_VERSION;
  std::stop_source stop;
  const Interrupts interrupts([&stop] { stop.request_stop(); });
  setup.work.stop = stop.get_token();
  return RunNode(setup);
}

}  // namespace

void AddNodeVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<NodeArguments>();
  CLI::App* verb = app.add_subcommand(
      "node", "Be one process of a graph; 'up' starts them, this is for those on other machines");
  verb->add_option("kind", arguments->kind,
                   "player, edges, detector, vio, mapper, recorder, camera or imu")
      ->check(CLI::IsMember(
          {"player", "edges", "detector", "vio", "mapper", "recorder", "camera", "imu"}))
      ->required();
  verb->add_option("--graph", arguments->graph, "The graph.json that 'up' has written")->required();
  verb->add_option("--name", arguments->name, "Its name there (default: the only one of the kind)");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return RunOneNode(*arguments); }; });
}

}  // namespace plumbline
