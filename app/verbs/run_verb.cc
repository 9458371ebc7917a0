// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>
#include <iostream>

#include <unistd.h>

#include <nlohmann/json.hpp>

#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/base/timer.h"
#include "engine/process/mapping_pipeline.h"

namespace plumbline {
namespace {

struct RunArguments {
  PipelineChoice choice;
  std::string out, frames, options_file, json, poses = "dataset";
  std::vector<std::string> settings;
  bool resume = false;
};

Status ReadOptions(RunArguments& arguments) {
  if (!arguments.options_file.empty()) {
    Result<nlohmann::json> json = ReadJson(arguments.options_file);
    if (!json.ok()) return json.error();
    if (Status status = OptionsFromJson(*json, arguments.choice.options); !status.ok()) {
      return Error{status.error().code, "'" + arguments.options_file + "': " + status.error().message};
    }
  }
  for (const std::string& setting : arguments.settings) {
    if (Status status = SetOption(setting, arguments.choice.options); !status.ok()) return status;
  }
  return {};
}

Status Run(RunArguments& arguments) {
  if (Status status = ReadOptions(arguments); !status.ok()) return status;
  Result<std::unique_ptr<MappingPipeline>> opened = MappingPipeline::Open(arguments.choice, {});
  if (!opened.ok()) return opened.error();
  MappingPipeline& pipeline = **opened;
  Stopwatch watch;
  int done = 0;
  while (auto snapshot = pipeline.Next()) {
    const FrameReport& report = (*snapshot)->report;
    if (done + 1 == pipeline.num_selected()) for (const auto& o : report.objects) {
      std::printf("FINAL %d %s %d conf %d ev %.1f std %.3f modes %zu", o.id.value, pipeline.database()->model(o.label).name.c_str(), (int)o.state, o.confirmed_frame.value_or(-1), o.log_evidence, o.modes[0].position_std_m, o.modes.size());
      for (int i = 0; i < 12; ++i) std::printf(" %.6f", o.world_from_object.matrix()(i / 4, i % 4));
      std::printf("\n"); for (auto& q : o.modes) std::printf("  mode %.2f at %.2f %.2f az %.0f\n", q.weight, q.world_from_object.translation().x(), q.world_from_object.translation().y(), std::atan2(q.world_from_object(1,0), q.world_from_object(0,0))*57.3);
    }
    for (const LifeEvent& event : report.events) {
      std::printf("%5d  object %d  %d %s\n", report.frame, event.object.value, static_cast<int>(event.kind), event.text.c_str());
    }
    ++done;
    if (done % 50 == 0) {
      std::printf("%5d  %.1f fps\n", report.frame, 1000.0 * done / watch.Milliseconds());
      for (const auto& o : report.objects) {
        std::printf("       %d %s s%d ev %.1f edge %.2f cnn %.2f std %.3f modes %zu at %.2f %.2f\n", o.id.value, o.category.c_str(),
                    (int)o.state, o.log_evidence, o.phi_edge, o.phi_cnn, o.modes[0].position_std_m, o.modes.size(),
                    o.world_from_object.translation().x(), o.world_from_object.translation().y());
      }
      for (const auto& t : report.timings) std::printf("       %s %.1f", t.stage.c_str(), t.milliseconds);
      std::printf("\n");
    }
  }
  return {};
}

}  // namespace

void AddRunVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* verb = app.add_subcommand("run", "Map a sequence: find its objects and leave a run file");
  verb->add_option("sequence", arguments->choice.sequence, "Folder of the sequence")->required();
  verb->add_option("--models", arguments->choice.models, "Folder of CAD models (default: the sequence's own)");
  verb->add_option("--out", arguments->out, "Run file to write (.plb)")->required();
  verb->add_option("--frames", arguments->frames, "Frames A:B or A:B:S; B is not included");
  verb->add_option("--seed", arguments->choice.seed, "Seed of all randomness");
  verb->add_option("--detector", arguments->choice.detector, "dataset, or an ONNX network with its sidecar")
      ->capture_default_str();
  verb->add_option("--edges", arguments->choice.edges,
                   "dataset, gradient, or an ONNX network with its sidecar (default: dataset where there are any)");
  verb->add_option("--options", arguments->options_file, "JSON file of filter options");
  verb->add_option("--set", arguments->settings, "One filter option, key=value; may be repeated");
  verb->add_option("--json", arguments->json, "Write the result here; - for standard output");
  verb->callback([arguments, &chosen] { chosen = [arguments] { 
    if (!arguments->frames.empty()) { auto r = ParseFrameRange(arguments->frames); if (!r.ok()) return Status(r.error()); arguments->choice.frames = *r; }
    return Run(*arguments); }; });
}

}  // namespace plumbline
