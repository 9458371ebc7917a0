// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "app/verbs/verb.h"
#include "engine/transport/curve_keys.h"

namespace plumbline {
namespace {

struct KeysArguments {
  std::vector<std::string> names;
  std::string out;
};

Status MakeKeys(const KeysArguments& arguments) {
  for (const std::string& name : arguments.names) {
    if (Status status = MakeCurveKeys(arguments.out, name); !status.ok()) return status;
    std::printf("made %s/%s.public (for all machines of the graph) and %s.secret (stays here)\n",
                arguments.out.c_str(), name.c_str(), name.c_str());
  }
  return {};
}

}  // namespace

void AddKeysVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<KeysArguments>();
  CLI::App* verb = app.add_subcommand(
      "keys", "Make the keys by which the nodes of a graph on several machines know one another");
  verb->add_option("names", arguments->names,
                   "Names of nodes in the graph, and of who looks on (viewer)")
      ->required();
  verb->add_option("--out", arguments->out,
                   "Folder of keys; a graph names it as \"keys\". Whoever has a .public there is "
                   "let in, and no one else")
      ->required();
  verb->callback([arguments, &chosen] { chosen = [arguments] { return MakeKeys(*arguments); }; });
}

}  // namespace plumbline
