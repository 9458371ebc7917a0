// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/demo_picture.h"
#include "app/verbs/demo_sequence.h"
#include "app/verbs/demo_window.h"
#include "app/verbs/verb.h"
#include "engine/analysis/object_looks.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr int kPictureEvery = 30;

struct DemoArguments {
  int frames = kDemoFrames;
  std::string out = "plumbline-demo";
  bool headless = false;
};

bool HasDisplay() {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return set("DISPLAY") || set("WAYLAND_DISPLAY");
}

/// Maps the sequence and writes the essence of what the window would show: pictures and a video.
/// For machines without a window.
Status WritePictures(const std::filesystem::path& sequence, const std::filesystem::path& out,
                     const WorkContext& work) {
  RunRecipe recipe;
  recipe.sequence = sequence;
  Result<std::unique_ptr<MappingPipeline>> opened = MappingPipeline::Open(recipe, work);
  if (!opened.ok()) return opened.error();
  MappingPipeline& pipeline = **opened;
  std::error_code error;
  std::filesystem::create_directories(out, error);
  const std::string video_file = (out / "demo.mp4").string();
  cv::VideoWriter video(video_file, cv::VideoWriter::fourcc('m', 'p', '4', 'v'),
                        pipeline.sequence().rate_hz(), kDemoPictureSize);
  if (!video.isOpened()) {
    return Error{ErrorCode::kIo, "cannot write '" + video_file +
                                     "'; choose a folder that can be written with --out"};
  }
  std::vector<FrameEvent> events;
  while (!work.stop.stop_requested()) {
    const auto snapshot = pipeline.Next();
    if (!snapshot) break;
    for (const LifeEvent& event : (*snapshot)->report.events)
      events.push_back({(*snapshot)->report.frame, event});
    const cv::Mat picture = DemoPicture(**snapshot, *pipeline.database(), LooksOf(events));
    video.write(picture);
    const int frame = (*snapshot)->report.frame;
    if (frame % kPictureEvery == kPictureEvery - 1) {
      char name[32];
      std::snprintf(name, sizeof(name), "frame_%06d.png", frame);
      if (!cv::imwrite((out / name).string(), picture)) {
        return Error{ErrorCode::kIo, "cannot write into '" + out.string() + "'"};
      }
    }
    work.report({"mapping", pipeline.num_done(), pipeline.num_selected()});
  }
  std::printf("wrote %s and a picture every %d frames beside it\n", video_file.c_str(),
              kPictureEvery);
  return {};
}

Status Demo(const DemoArguments& arguments) {
  const bool headless = arguments.headless || !HasDisplay();
  const Result<std::filesystem::path> sequence = [&] {
    ConsoleWork console;
    return BuiltInSequence(arguments.frames, console.context());
  }();
  if (!sequence.ok()) return sequence.error();
  if (!headless) {
    const Status shown = ShowDemoWindow(*sequence);
    if (shown.ok() || shown.error().code != ErrorCode::kUnsupported) return shown;
    std::fprintf(stderr, "%s\n", shown.error().message.c_str());
  }
  std::printf("there is no display: writing pictures and a video into '%s' instead\n",
              arguments.out.c_str());
  ConsoleWork console;
  const WorkContext work = console.context();
  const Status filmed = FilmDemoWindow(*sequence, arguments.out, work);
  if (filmed.ok() || (filmed.error().code != ErrorCode::kUnsupported &&
                      filmed.error().code != ErrorCode::kNotFound)) {
    return filmed;
  }
  std::fprintf(stderr, "%s; the pictures are simpler for it\n", filmed.error().message.c_str());
  return WritePictures(*sequence, arguments.out, work);
}

}  // namespace

void AddDemoVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<DemoArguments>();
  CLI::App* verb = app.add_subcommand(
      "demo", "Show the built-in sequence; without a display write pictures and a video");
  verb->add_option("--frames", arguments->frames, "Length of the built-in sequence")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  verb->add_option("--out", arguments->out, "Folder for pictures and video")->capture_default_str();
  verb->add_flag("--headless", arguments->headless, "Write pictures even where there is a display");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Demo(*arguments); }; });
}

}  // namespace plumbline
