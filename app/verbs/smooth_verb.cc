// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include <nlohmann/json.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/smoothed_table.h"
#include "app/verbs/verb.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_inputs.h"
#include "engine/recording/run_summary.h"
#include "engine/recording/smoothed_record.h"

namespace plumbline {
namespace {

struct SmoothArguments {
  RunChoice choice;
  std::string json;
};

Status SmoothFile(const SmoothArguments& arguments) {
  const std::string run = arguments.choice.run.string();
  ConsoleWork console;
  const WorkContext work = console.context();
  Result<std::unique_ptr<MappingPipeline>> pipeline = [&]() {
    const auto reader = RunReader::Open(run);
    using Opened = Result<std::unique_ptr<MappingPipeline>>;
    if (!reader.ok()) return Opened(reader.error());
    // Names what differs where the models are not those of the run.
    const auto models = LoadModelsOfRun(arguments.choice, (*reader)->header());
    if (!models.ok()) return Opened(models.error());
    const auto own_poses = (*reader)->ReadOwnPoses();
    if (!own_poses.ok()) return Opened(own_poses.error());
    return MappingPipeline::Open(RecipeOf(arguments.choice, (*reader)->header()), work, *own_poses);
  }();
  if (!pipeline.ok()) return pipeline.error();
  const Result<SmoothedMap> smoothed = SmoothRun(run, **pipeline, work);
  if (!smoothed.ok()) return NotSmoothed(smoothed.error(), run);
  if (arguments.json != "-") PrintSmoothed(*smoothed, *(*pipeline)->database());
  if (arguments.json.empty()) return {};
  const auto reader = RunReader::Open(run);
  if (!reader.ok()) return reader.error();
  const Result<nlohmann::json> json = RunResultJson(**reader, (*pipeline)->database().get());
  if (!json.ok()) return json.error();
  return WriteJsonResult(arguments.json, *json);
}

}  // namespace

void AddSmoothVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<SmoothArguments>();
  CLI::App* verb = app.add_subcommand(
      "smooth", "Smooth a run that has ended: a second pass over all frames, kept in its file");
  verb->add_option("run", arguments->choice.run, "A run file; the run itself stays as it is")
      ->required()
      ->type_name("RUN.plb");
  verb->add_option("--sequence", arguments->choice.sequence,
                   "The sequence of the run, if it has moved")
      ->type_name("DIR");
  verb->add_option("--models", arguments->choice.models,
                   "The models of the run, if they have moved")
      ->type_name("DIR");
  verb->add_option("--json", arguments->json,
                   "Write the result of the run with its smoothed map here; - for standard output");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return SmoothFile(*arguments); }; });
}

}  // namespace plumbline
