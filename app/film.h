// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/application.h"
#include "engine/base/progress.h"

namespace plumbline {

struct Film {
  std::filesystem::path video;  ///< Empty if no encoder was at hand.
  std::vector<std::filesystem::path> pictures;
  int frames = 0;
};

/// Steps through everything that is open in `application` and keeps what the window shows: every
/// frame in FOLDER/demo.mp4 at the rate of the sequence, and four frames as PNG. Errors: kIo,
/// kCancelled; what the process fails with.
Result<Film> FilmWindow(Application& application, const std::filesystem::path& folder,
                        const WorkContext& work);

}  // namespace plumbline
