// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/synthetic/sequence_writer.h"

namespace plumbline {
namespace {

struct SynthArguments {
  std::string out_folder;
  std::string scene = "room";
  SyntheticOptions options;
};

Status Synth(SynthArguments arguments) {
  arguments.options.scene = *SyntheticSceneFromName(arguments.scene);
  ConsoleWork work;
  const Result<SyntheticSummary> summary =
      WriteSyntheticSequence(arguments.options, arguments.out_folder, work.context());
  if (!summary.ok()) return summary.error();
  std::printf("%s: %d frames, %d objects (light %.1f s, %.2f s a frame)\n",
              arguments.out_folder.c_str(), summary->frames, summary->instances,
              summary->light_seconds, summary->frame_seconds / summary->frames);
  return {};
}

}  // namespace

void AddSynthVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<SynthArguments>();
  CLI::App* verb = app.add_subcommand(
      "synth", "Make a sequence with exact truth: a furnished room, filmed by a walking camera");
  verb->add_option("--out", arguments->out_folder,
                   "Folder of the sequence: new, empty, or an earlier synthetic one (replaced)")
      ->required()
      ->type_name("DIR");
  verb->add_option("--scene", arguments->scene,
                   "room, or a situation: occlusion, clutter, blur, lowcontrast (furniture in the "
                   "colours of the room), truncation, duplicate (split and double boxes), variant "
                   "(an object differs from its model)")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kSyntheticSceneNames),
                                                     std::end(kSyntheticSceneNames))))
      ->capture_default_str();
  verb->add_option("--frames", arguments->options.frames, "Number of frames, 30 a second")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  verb->add_option("--seed", arguments->options.seed,
                   "Chooses room, furniture, colours, light and walk; 1 is the demo")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Synth(*arguments); }; });
}

}  // namespace plumbline
