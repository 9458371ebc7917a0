// SPDX-License-Identifier: Apache-2.0
// The window on made-up frames: fake_window [--script FILE] [--settings FILE] [--size W H]
// [--frames N] [--state FILE] [--film OUT --layout NAME]
// [--open PATH] [--sequence FOLDER] [--annotator NAME] [--slow MS] [--fail FRAME] [--recorded].
// Tests drive it; it needs a display.

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>

#include "app/film/film.h"
#include "app/window/application.h"
#include "tests/support/fake_source.h"

int main(int argc, char** argv) {
  plumbline::FakeSourceOptions fake;
  plumbline::ApplicationOptions options;
  options.path = "made-up room";
  std::string film;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const auto next = [&] { return std::string(++i < argc ? argv[i] : "0"); };
    if (option == "--script") options.script = next();
    if (option == "--open") options.path = next();
    if (option == "--sequence") options.annotation.sequence = next();
    if (option == "--annotator") options.annotation.annotator = next();
    if (option == "--settings") options.settings = next();
    if (option == "--film") film = next();
    if (option == "--layout") options.inspect.layout = *plumbline::FindRenderLayout(next());
    if (option == "--state") options.state_file = next();
    if (option == "--frames") fake.num_frames = std::stoi(next());
    if (option == "--slow") fake.milliseconds_per_frame = std::stoi(next());
    if (option == "--fail") fake.fail_at_frame = std::stoi(next());
    if (option == "--demo") options.inspect.present = true;
    if (option == "--recorded") fake.recorded = true;
    if (option == "--scale") options.ui_scale = std::stod(next());
    if (option == "--size") {
      options.width = std::stoi(next());
      options.height = std::stoi(next());
    }
    if (option == "--image") {
      fake.width = std::stoi(next());
      fake.height = std::stoi(next());
    }
  }
  options.inspect.opener =
      [fake](const std::string& path,
             const plumbline::OpenWith& with) -> plumbline::MappingProcess::OpenSource {
    return [fake, path, models = with.models,
            find_poses = with.find_poses](const plumbline::WorkContext&)
               -> plumbline::Result<std::unique_ptr<plumbline::SnapshotSource>> {
      if (!models.empty()) std::ofstream("models.txt") << models;
      if (path == "missing")
        return plumbline::Error{plumbline::ErrorCode::kNotFound, "there is no sequence 'missing'"};
      if (path == "modelless" && find_poses)
        return plumbline::Error{plumbline::ErrorCode::kNotFound, "'modelless' has no models"};
      if ((path == "poseless" || path == "modelless") && !find_poses)
        return plumbline::Error{plumbline::ErrorCode::kInvalidInput, "'" + path + "' has no poses"};
      return plumbline::MakeFakeSource(fake);
    };
  };
  auto application = plumbline::Application::Create(std::move(options));
  if (!application.ok()) {
    std::cerr << application.error().message << std::endl;
    return 1;
  }
  if (!film.empty()) {
    auto sink = plumbline::OpenFilm(film, 10);
    const auto take = [&](const cv::Mat& picture, int frame) {
      return (*sink)->Take(picture, frame);
    };
    const auto filmed = plumbline::FilmFrames(**application, {6, 2}, {}, take);
    const bool good = filmed.ok() && *filmed == 3 && (*sink)->Finish().ok();
    return good ? 0 : 1;
  }
  const plumbline::Status status = (*application)->Run();
  if (status.ok()) return 0;
  std::cerr << status.error().message << std::endl;
  return 1;
}
