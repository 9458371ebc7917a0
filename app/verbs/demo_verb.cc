// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/demo_picture.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/process/mapping_pipeline.h"
#include "engine/synthetic/sequence_writer.h"

namespace plumbline {
namespace {

constexpr int kPictureEvery = 30;

struct DemoArguments {
  int frames = 150;
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

/// The built-in sequence: filmed on first use into the cache, complete or not there at all.
Result<std::filesystem::path> BuiltInSequence(int frames, const WorkContext& work) {
  const std::string name = "demo-room-" PLUMBLINE_VERSION "-" + std::to_string(frames);
  const std::filesystem::path folder = CacheDirectory() / name;
  const std::filesystem::path done = CacheDirectory() / (name + ".complete");
  std::error_code error;
  if (std::filesystem::exists(done, error) && std::filesystem::exists(folder, error)) return folder;
  std::fprintf(stderr, "filming the built-in room, once (into %s)\n", folder.c_str());
  SyntheticOptions options;
  options.frames = frames;
  Result<SyntheticSummary> made = WriteSyntheticSequence(options, folder, work);
  if (!made.ok()) return made.error();
  if (Status status = WriteFileAtomically(done, "complete\n"); !status.ok()) return status.error();
  return folder;
}

/// Maps the sequence and writes what the window would show: pictures and a video.
Status WritePictures(const std::filesystem::path& sequence, const std::filesystem::path& out,
                     const WorkContext& work) {
  PipelineChoice choice;
  choice.sequence = sequence;
  Result<std::unique_ptr<MappingPipeline>> opened = MappingPipeline::Open(choice, work);
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
  while (!work.stop.stop_requested()) {
    const auto snapshot = pipeline.Next();
    if (!snapshot) break;
    const cv::Mat picture = DemoPicture(**snapshot, *pipeline.database());
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
  std::filesystem::path sequence;
  {
    ConsoleWork console;
    const WorkContext work = console.context();
    Result<std::filesystem::path> made = BuiltInSequence(arguments.frames, work);
    if (!made.ok()) return made.error();
    sequence = *made;
    if (arguments.headless || !HasDisplay()) {
      std::printf("there is no display: writing pictures and a video into '%s' instead\n",
                  arguments.out.c_str());
      return WritePictures(sequence, arguments.out, work);
    }
  }
  // The window is the gui command of this same program.
  ::execl("/proc/self/exe", "plumbline", "gui", sequence.c_str(), static_cast<char*>(nullptr));
  return Error{ErrorCode::kIo, std::string("cannot start the window: ") + std::strerror(errno)};
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
