// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/verbs/argument_checks.h"
#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/geometry/angles.h"
#include "engine/synthetic/sequence_writer.h"

namespace plumbline {
namespace {

struct SynthArguments {
  std::string out_folder;
  std::string scene = "room";
  std::string size;  ///< Empty: that of the scene.
  std::uint64_t seed = 1;
  std::optional<int> frames, light_rays;
  std::optional<double> rate_hz, fov_deg;
  double rolling_shutter_s = 0;
  double model_error_percent = 0;
  bool flawless = false, imu = false, tracks_only = false;
  double imu_rate_hz = 200, imu_noise = 1, time_offset_ms = 0, rest_s = 0, tremor = 0;
  std::vector<double> wrong_camera = {0, 0};  ///< Degrees and centimetres.
};

Result<SyntheticOptions> OptionsOf(const SynthArguments& arguments) {
  SyntheticOptions options = OptionsFor(*SyntheticSceneFromName(arguments.scene));
  options.seed = arguments.seed;
  if (arguments.rate_hz) {
    const double seconds = options.frames / options.rate_hz;
    options.rate_hz = *arguments.rate_hz;
    options.frames = static_cast<int>(std::lround(seconds * options.rate_hz));
  }
  if (arguments.frames) options.frames = *arguments.frames;
  if (arguments.imu) {
    ImuSimulation& imu = options.imu.emplace();
    imu.rate_hz = arguments.imu_rate_hz;
    imu.noise = arguments.imu_noise;
    imu.time_offset_s = arguments.time_offset_ms / 1000;
    imu.wrong_rotation_rad = arguments.wrong_camera[0] * kRadPerDeg;
    imu.wrong_translation_m = arguments.wrong_camera[1] / 100;
    imu.rest_s = arguments.rest_s;
    imu.tremor = arguments.tremor;
    if (!arguments.frames) options.frames += static_cast<int>(imu.rest_s * options.rate_hz);
  }
  options.tracks_only = arguments.tracks_only;
  options.flawless = arguments.flawless;
  options.model_error = arguments.model_error_percent / 100;
  options.rolling_shutter_s = arguments.rolling_shutter_s;
  if (arguments.light_rays) options.light_rays = *arguments.light_rays;
  if (arguments.fov_deg) options.horizontal_fov_rad = *arguments.fov_deg * kRadPerDeg;
  char rest = 0;
  if (!arguments.size.empty() &&
      std::sscanf(arguments.size.c_str(), "%dx%d%c", &options.width, &options.height, &rest) != 2) {
    return Error{ErrorCode::kInvalidInput,
                 "--size is '" + arguments.size + "'; write width x height, for instance 640x480"};
  }
  return options;
}

Status Synth(const SynthArguments& arguments) {
  const Result<SyntheticOptions> options = OptionsOf(arguments);
  if (!options.ok()) return options.error();
  ConsoleWork work;
  const Result<SyntheticSummary> summary =
      WriteSyntheticSequence(*options, arguments.out_folder, work.context());
  if (!summary.ok()) return summary.error();
  if (options->tracks_only) {
    std::printf("%s: tracks of %d frames (%.1f s)\n", arguments.out_folder.c_str(), summary->frames,
                summary->frame_seconds);
    return {};
  }
  std::printf("%s: %d frames, %d objects (light %.1f s, %.2f s a frame)\n",
              arguments.out_folder.c_str(), summary->frames, summary->instances,
              summary->light_seconds, summary->frame_seconds / summary->frames);
  return {};
}

/// One line for each scene.
std::string SceneList() {
  std::string list;
  for (const SyntheticSceneInfo& scene : kSyntheticScenes) {
    std::array<char, 200> line;
    std::snprintf(line.data(), line.size(), "\n  %-12s %.*s (%d frames at %g Hz)",
                  std::string(scene.name).c_str(), static_cast<int>(scene.summary.size()),
                  scene.summary.data(), scene.frames, scene.rate_hz);
    list += line.data();
  }
  return list;
}

void AddImuOptions(CLI::App& verb, SynthArguments& arguments) {
  verb.add_flag("--imu", arguments.imu,
                "Write an IMU too: imu.csv, imu.json, groundtruth.csv, and where the camera sits");
  verb.add_option("--imu-rate", arguments.imu_rate_hz, "Readings per second")
      ->needs("--imu")
      ->check(CLI::Range(50.0, 2000.0))
      ->type_name("HZ")
      ->capture_default_str();
  verb.add_option("--imu-noise", arguments.imu_noise,
                  "Times the noise and bias walk that imu.json states; 0 for none")
      ->needs("--imu")
      ->check(CLI::Range(0.0, 100.0))
      ->type_name("FACTOR")
      ->capture_default_str();
  verb.add_option("--time-offset", arguments.time_offset_ms,
                  "True offset of the IMU's clock from the images'; imu.json states 0")
      ->needs("--imu")
      ->check(CLI::Range(-500.0, 500.0))
      ->type_name("MS")
      ->capture_default_str();
  verb.add_option("--wrong-camera", arguments.wrong_camera,
                  "What the camera's pose in camera.json is wrong by, about and along each axis")
      ->needs("--imu")
      ->expected(2)
      ->check(CLI::Range(0.0, 50.0))
      ->type_name("DEG CM");
  verb.add_option("--rest", arguments.rest_s, "Stand still at the start, for so long")
      ->needs("--imu")
      ->check(CLI::Range(0.0, 3600.0))
      ->type_name("S")
      ->capture_default_str();
  verb.add_option("--tremor", arguments.tremor, "Tremor of the hands: 1 is a steady one's")
      ->needs("--imu")
      ->check(CLI::Range(0.0, 50.0))
      ->type_name("FACTOR")
      ->capture_default_str();
  verb.add_flag("--tracks", arguments.tracks_only,
                "No images: points that are followed through the room, as tracks.csv")
      ->needs("--imu");
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
  std::vector<std::string> names;
  for (const SyntheticSceneInfo& scene : kSyntheticScenes) names.emplace_back(scene.name);
  verb->add_option("--scene", arguments->scene, "What is filmed; the scenes are listed below")
      ->check(CLI::IsMember(names))
      ->type_name("NAME")
      ->capture_default_str();
  verb->add_option("--frames", arguments->frames,
                   "Number of frames; if not given, as long as the scene's story takes")
      ->check(CLI::Range(1, 100000));
  verb->add_option("--rate", arguments->rate_hz,
                   "Frames per second; if not given, those of the scene")
      ->check(CLI::Range(1.0, 240.0))
      ->type_name("HZ");
  verb->add_option("--size", arguments->size,
                   "Width x height of the images [px]; if not given, 960x500 (street: 1242x375)")
      ->type_name("WxH");
  verb->add_option("--fov", arguments->fov_deg,
                   "Field of view from left to right; if not given, 81 degrees")
      ->check(CLI::Range(20.0, 150.0))
      ->type_name("DEG");
  verb->add_option("--rolling-shutter", arguments->rolling_shutter_s,
                   "Time from the first row of an image to the last, each exposed from its own "
                   "pose; negative: the last row is read first")
      ->check(CLI::Range(-0.2, 0.2))
      ->type_name("S")
      ->capture_default_str();
  verb->add_option("--seed", arguments->seed,
                   "Chooses room, furniture, colours, light and walk; 1 is the demo")
      ->check(IsSeed())
      ->capture_default_str();
  verb->add_flag("--flawless", arguments->flawless,
                 "Boxes and edges as perfect networks would give them: of all that shows, exact");
  verb->add_option(
          "--light-rays", arguments->light_rays,
          "Rays by which the light of each point is computed; 16 are an eighth of the work "
          "and leave some grain on the walls")
      ->check(CLI::Range(4, 1024))
      ->type_name("N");
  verb->add_option("--model-error", arguments->model_error_percent,
                   "Each model of the database is larger or smaller than its objects by this")
      ->check(CLI::Range(0.0, 20.0))
      ->type_name("PERCENT")
      ->capture_default_str();
  AddImuOptions(*verb, *arguments);
  verb->footer("Scenes (docs/algorithms/synthetic.md):" + SceneList());
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Synth(*arguments); }; });
}

}  // namespace plumbline
