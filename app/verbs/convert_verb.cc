// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/scenenn_models.h"
#include "app/verbs/verb.h"
#include "engine/dataset/sequence.h"
#include "engine/dataset/sequence_formats.h"
#include "engine/models/model_source.h"

namespace plumbline {
namespace {

struct ConvertArguments {
  std::string source, layout = "plumbline", out_folder, poses, models, json;
  std::optional<int> jpeg_quality;
};

const SequenceFormat* FormatNamed(const std::string& name) {
  for (const SequenceFormat& format : SequenceFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

Status Convert(const ConvertArguments& arguments) {
  const auto sequence = OpenSequence(arguments.source, {arguments.poses});
  if (!sequence.ok()) return sequence.error();
  const SequenceFormat& layout = *FormatNamed(arguments.layout);
  WriteOptions options{arguments.jpeg_quality, {}};
  if (!arguments.models.empty()) {
    auto frames = ReadObjectFromFile(arguments.models);
    if (!frames.ok()) return frames.error();
    if (frames->empty())
      return Error{
          ErrorCode::kInvalidInput,
          "no model of '" + arguments.models +
              "' tells where it stands in its mesh file; build them with `plumbline models "
              "build`"};
    options.models = std::move(*frames);
  }
  ConsoleWork work;
  Result<WrittenSequence> written =
      layout.write(**sequence, arguments.out_folder, options, work.context());
  if (!written.ok()) return written.error();
  if (layout.name == "plumbline") {
    if (Status cropped = CropSceneNnModels(**sequence, arguments.out_folder, written->warnings);
        !cropped.ok())
      return cropped;
  }
  const bool quiet = arguments.json == "-";
  if (!quiet) {
    std::printf(
        "%s: %s, %d frames, %d with pose, %d with depth%s\n", arguments.out_folder.c_str(),
        std::string(layout.title).c_str(), written->frames, written->poses, written->depth_images,
        written->skipped > 0 ? (", " + std::to_string(written->skipped) + " skipped").c_str() : "");
    for (const std::string& warning : (*sequence)->warnings())
      std::printf("  ! %s\n", warning.c_str());
    for (const std::string& warning : written->warnings) std::printf("  ! %s\n", warning.c_str());
  }
  if (arguments.json.empty()) return {};
  std::vector<std::string> odd = (*sequence)->warnings();
  odd.insert(odd.end(), written->warnings.begin(), written->warnings.end());
  return WriteJsonResult(arguments.json, {{"layout", layout.name},
                                          {"path", arguments.out_folder},
                                          {"frames", written->frames},
                                          {"skipped", written->skipped},
                                          {"poses", written->poses},
                                          {"depth_images", written->depth_images},
                                          {"odd", odd}});
}

}  // namespace

void AddConvertVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* verb =
      app.add_subcommand("convert", "Write a sequence of any data set in another layout");
  verb->add_option("source", arguments->source, "A sequence that `info` knows")
      ->required()
      ->type_name("SEQUENCE");
  std::vector<std::string> written;
  std::string read;
  for (const SequenceFormat& format : SequenceFormats()) {
    if (format.write != nullptr) written.emplace_back(format.name);
    read += "\n  " + std::string(format.title) + ": " + std::string(format.expects);
  }
  verb->add_option("--to", arguments->layout, "The layout to write")
      ->check(CLI::IsMember(written))
      ->type_name("LAYOUT")
      ->capture_default_str();
  verb->add_option("--out", arguments->out_folder, "The folder to write, new or empty")
      ->required()
      ->type_name("DIR");
  verb->add_option("--poses", arguments->poses,
                   "A trajectory (TUM) in place of the data set's poses")
      ->type_name("FILE");
  verb->add_option("--models", arguments->models,
                   "The models that `models build` made of the data set's meshes, for the ground "
                   "truth to pose")
      ->type_name("DIR");
  verb->add_option("--jpeg", arguments->jpeg_quality,
                   "Write images as JPEG of this quality; without it as PNG, which loses nothing")
      ->check(CLI::Range(1, 100))
      ->type_name("QUALITY");
  verb->add_option("--json", arguments->json, "Write what was done as JSON (- for standard output)")
      ->type_name("FILE");
  verb->footer("Reads (docs/data_sets.md):" + read);
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Convert(*arguments); }; });
}

}  // namespace plumbline
