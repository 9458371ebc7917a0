// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/pipeline_arguments.h"

#include <charconv>

#include <nlohmann/json.hpp>

#include "app/verbs/argument_checks.h"
#include "engine/base/files.h"
#include "engine/vision/fetched_networks.h"

namespace plumbline {
namespace {

/// Of --live and --live=SPEED.
Result<double> LiveSpeed(const std::string& text) {
  double speed = 0;
  if (text == "true") return 1.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), speed);
  if (error == std::errc() && end == text.data() + text.size()) return speed;
  return Error{ErrorCode::kInvalidInput,
               "'" + text + "' is no speed; write --live, or --live=0.5 for half the speed"};
}

}  // namespace

void PipelineArguments::AddTo(CLI::App& verb) {
  verb.add_option("--models", recipe.models, "Folder of CAD models (default: the sequence's own)");
  verb.add_option("--frames", frames, "Frames A:B or A:B:S; B is not included");
  verb.add_option("--seed", recipe.seed, "Seed of all randomness, a whole number from 0")
      ->check(IsSeed())
      ->capture_default_str();
  verb.add_option(
      "--detector", detector,
      "dataset (the sequence's proposals), builtin (our network), one that 'networks get' has "
      "fetched, or FILE.onnx with its sidecar (default: dataset where there are any, else the best "
      "that was fetched, else builtin)");
  verb.add_option(
      "--edges", edges,
      "dataset, builtin (our network), builtin-half (half as wide, two to three times as fast), "
      "gradient, or "
      "FILE.onnx with its sidecar (default: dataset where there are any, else builtin)");
  verb.add_option(
          "--poses", poses,
          "dataset (the sequence's own); vio: from its images and IMU alone, in a world of "
          "its own with gravity and a floor found from points; drift is corrected where places are "
          "seen again, before mapping, unless --set-poses loops=causal or off; or a trajectory: "
          "FILE with rows t tx ty tz qx qy qz "
          "qw (TUM), of the camera, or of the body if its first line says # world_from_body. "
          "It must be in the sequence's gravity-aligned world: gravity and floor are those "
          "of gravity.json")
      ->type_name("dataset|vio|FILE")
      ->capture_default_str();
  verb.add_option(
      "--set-poses", pose_settings,
      "With --poses vio: one option of tracker, filter or loops, key=value; may be repeated. "
      "loops=off, causal or corrected (default): what becomes of a place known again");
  verb.add_option("--scorer", scorer,
                  "viewpoint (fast), or rendered: the reference, about a thousand times slower")
      ->check(CLI::IsMember({"viewpoint", "rendered"}))
      ->capture_default_str();
  verb.add_option("--preset", preset,
                  "default, or paper: the filter of the paper's authors, for comparison; --options "
                  "and --set change it further")
      ->check(CLI::IsMember({"default", "paper"}))
      ->capture_default_str();
  verb.add_option("--options", options_file, "JSON file of filter options");
  verb.add_option("--set", settings, "One filter option, key=value; may be repeated");
}

void PipelineArguments::AddLiveTo(CLI::App& verb) {
  verb.add_flag(
      "--live", live,
      "Play the recording by the clock, as a camera would give it: the mapper gets the newest "
      "image whenever it is ready for one, and what came meanwhile is passed over. --live=0.5 "
      "plays at half the speed. Such a run cannot be repeated (default: every frame is mapped, "
      "however long it takes)");
}

Status PipelineArguments::Finish() {
  if (!live.empty()) {
    Result<double> speed = LiveSpeed(live);
    if (!speed.ok()) return speed.error();
    recipe.live_speed = *speed;
  }
  recipe.poses = ParsePoses(poses);
  if (!detector.empty()) {
    const Result<std::string> resolved = ResolveNetworkName(detector);
    if (!resolved.ok()) return resolved.error();
    recipe.detector = ParseDetector(*resolved);
  }
  if (!edges.empty()) recipe.edges = ParseEdges(edges);
  recipe.scorer = scorer == "rendered" ? ScorerKind::kRendered : ScorerKind::kViewpoint;
  if (!frames.empty()) {
    Result<FrameRange> range = ParseFrameRange(frames);
    if (!range.ok()) return range.error();
    recipe.frames = *range;
  }
  if (preset == "paper") recipe.options.filter = FilterKind::kPaper;
  if (!options_file.empty()) {
    Result<nlohmann::json> json = ReadJson(options_file);
    if (!json.ok()) return json.error();
    if (Status status = OptionsFromJson(*json, recipe.options); !status.ok()) {
      return Error{status.error().code, "'" + options_file + "': " + status.error().message};
    }
  }
  for (const std::string& setting : settings) {
    if (Status status = SetOption(setting, recipe.options); !status.ok()) return status;
  }
  if (!pose_settings.empty() && recipe.poses.source != PoseSource::kVio)
    return Error{ErrorCode::kInvalidInput, "--set-poses goes with --poses vio"};
  // Nobody who maps while images come can wait for poses that later ones correct.
  if (recipe.live_speed) recipe.own_poses.loops = LoopUse::kCausal;
  for (const std::string& setting : pose_settings) {
    if (Status status = SetOption(setting, recipe.own_poses); !status.ok()) return status;
  }
  return {};
}

}  // namespace plumbline
