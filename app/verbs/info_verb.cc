// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include "app/info/path_info.h"
#include "app/verbs/verb.h"

namespace plumbline {
namespace {

struct InfoArguments {
  std::string path, json;
};

Status Info(const InfoArguments& arguments) {
  const Result<PathInfo> info = DescribePath(arguments.path);
  if (!info.ok()) return info.error();
  if (arguments.json != "-") {
    std::printf("%s: %s\n", arguments.path.c_str(), info.value().title.c_str());
    for (const InfoLine& line : info.value().lines)
      std::printf("  %-11s %s\n", line.label.c_str(), line.text.c_str());
    for (const std::string& sentence : info.value().odd) std::printf("  ! %s\n", sentence.c_str());
  }
  if (arguments.json.empty()) return {};
  return WriteJsonResult(arguments.json, info.value().json);
}

}  // namespace

void AddInfoVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<InfoArguments>();
  CLI::App* verb = app.add_subcommand(
      "info", "Describe a file or folder: what it is, what it holds, and what is odd about it");
  verb->add_option("path", arguments->path,
                   "A sequence, run, scan or mesh, folder of models, annotation project, network, "
                   "or trajectory")
      ->required()
      ->type_name("PATH");
  verb->add_option("--json", arguments->json, "Write the same as JSON (- for standard output)")
      ->type_name("FILE");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Info(*arguments); }; });
}

}  // namespace plumbline
