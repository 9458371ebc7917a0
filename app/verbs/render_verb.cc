// SPDX-License-Identifier: Apache-2.0
#include <stdlib.h>

#include <cstdio>
#include <memory>
#include <string>

#include "app/film/film.h"
#include "app/film/render_layout.h"
#include "app/platform/virtual_display.h"
#include "app/verbs/console_work.h"
#include "app/verbs/open_source.h"
#include "app/verbs/pipeline_arguments.h"
#include "app/verbs/verb.h"
#include "app/verbs/window_arguments.h"
#include "app/window/application.h"

namespace plumbline {
namespace {

struct RenderArguments {
  PipelineArguments pipeline;
  WindowArguments window;
  std::string path, sequence, out, layout = "inspect";
  int select = 0;
  double rate_hz = 0;
  bool light = false;
};

Status Render(RenderArguments& arguments) {
  if (Status status = arguments.pipeline.Finish(); !status.ok()) return status;
  const auto layout = FindRenderLayout(arguments.layout);
  if (!layout.ok()) return layout.error();
  // A run is stepped through; a sequence is mapped in those steps.
  FrameRange range = arguments.pipeline.choice.frames;
  const bool recorded = std::filesystem::path(arguments.path).extension() == ".plb";
  ApplicationOptions options;
  if (Status status = arguments.window.Apply(options); !status.ok()) return status;
  options.settings.clear();  // the same film for everybody
  options.opener = SourceOpener({arguments.pipeline.choice, {}, PLUMBLINE_VERSION},
                                {{}, arguments.sequence, arguments.pipeline.choice.models});
  options.path = arguments.path;
  options.start_frame = range.begin;
  options.layout = *layout;
  options.light = arguments.light;
  options.ignore_pointer = true;
  options.select = ObjectId{arguments.select};

  // A display of its own even where there is one: nothing may cover the window while it is filmed.
  auto display = VirtualDisplay::Start(options.width, options.height);
  if (!display.ok()) return display.error();
  setenv("DISPLAY", (*display)->name().c_str(), 1);
  auto application = Application::Create(std::move(options));
  if (!application.ok()) return application.error();
  ConsoleWork console;
  std::unique_ptr<FilmSink> sink;
  const auto take = [&](const cv::Mat& picture, int frame) -> Status {
    if (sink == nullptr) {
      const double rate_hz = (*application)->context().sequence->rate_hz / range.step;
      auto opened = OpenFilm(arguments.out, arguments.rate_hz > 0 ? arguments.rate_hz : rate_hz);
      if (!opened.ok()) return opened.error();
      sink = std::move(opened).value();
    }
    return sink->Take(picture, frame);
  };
  const auto filmed =
      FilmFrames(**application, {range.end, recorded ? range.step : 1}, console.context(), take);
  if (!filmed.ok()) return filmed.error();
  if (*filmed == 0)
    return Error{ErrorCode::kInvalidInput, "the range of --frames has no frames here"};
  if (Status status = sink->Finish(); !status.ok()) return status;
  std::printf("wrote %s (%d frames)\n", arguments.out.c_str(), *filmed);
  return {};
}

}  // namespace

void AddRenderVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* verb = app.add_subcommand(
      "render", "Film a run or a sequence as the window shows it; needs no display");
  verb->add_option("path", arguments->path, "Run file (.plb), or folder of a sequence")->required();
  std::string layouts = "What it shows:";
  for (const RenderLayout& layout : RenderLayouts())
    layouts += std::string("\n  ") + layout.name + ": " + layout.meaning;
  verb->add_option("--layout", arguments->layout, layouts)->capture_default_str();
  verb->add_option("--out", arguments->out, "FILE.mp4, FILE.gif, or a folder for PNG")->required();
  verb->add_option("--rate", arguments->rate_hz, "Pictures per second (default: as recorded)")
      ->check(CLI::Range(0.1, 240.0));
  verb->add_option("--select", arguments->select, "Number of the object to select");
  verb->add_flag("--light", arguments->light, "Light theme");
  verb->add_option("--sequence", arguments->sequence, "Where the sequence of a run file is now");
  arguments->pipeline.AddTo(*verb);
  arguments->window.AddTo(*verb);
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Render(*arguments); }; });
}

}  // namespace plumbline
