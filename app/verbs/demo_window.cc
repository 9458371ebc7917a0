// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/demo_window.h"

#include <stdlib.h>

#include <cstdio>

#include "app/film/film.h"
#include "app/platform/virtual_display.h"
#include "app/verbs/open_source.h"
#include "app/window/application.h"

namespace plumbline {
namespace {

ApplicationOptions Options(const std::filesystem::path& sequence) {
  ApplicationOptions options;
  MappingChoice live;
  live.program_version = PLUMBLINE_VERSION;
  options.opener = SourceOpener(live, {});
  options.path = sequence.string();
  return options;
}

}  // namespace

Status ShowDemoWindow(const std::filesystem::path& sequence) {
  ApplicationOptions options = Options(sequence);
  options.play = true;
  options.settings = DefaultSettingsFile();
  auto application = Application::Create(std::move(options));
  if (!application.ok()) return application.error();
  return (*application)->Run();
}

Status FilmDemoWindow(const std::filesystem::path& sequence, const std::filesystem::path& out,
                      const WorkContext& work) {
  ApplicationOptions options = Options(sequence);
  options.ignore_pointer = true;
  auto display = VirtualDisplay::Start(options.width, options.height);
  if (!display.ok()) return display.error();
  setenv("DISPLAY", (*display)->name().c_str(), 1);
  auto application = Application::Create(std::move(options));
  if (!application.ok()) return application.error();
  const auto film = FilmWindow(**application, out, work);
  if (!film.ok()) return film.error();
  for (const auto& picture : film->pictures) std::printf("wrote %s\n", picture.c_str());
  if (film->video.empty()) {
    std::printf("no video: OpenCV has no encoder for MP4 here\n");
  } else {
    std::printf("wrote %s (%d frames)\n", film->video.c_str(), film->frames);
  }
  return {};
}

}  // namespace plumbline
