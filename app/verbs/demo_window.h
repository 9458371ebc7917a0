// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/base/progress.h"
#include "engine/base/result.h"

namespace plumbline {

/// Plays a sequence in the window until it is closed. Errors: kUnsupported where this build or this
/// machine has no window.
Status ShowDemoWindow(const std::filesystem::path& sequence);

/// Films the window on a display of its own while it maps the sequence: demo.mp4 and a few pictures
/// in `out`. Errors: kUnsupported, kNotFound where that cannot be had here (no window in the build,
/// no Xvfb); kIo, kCancelled.
Status FilmDemoWindow(const std::filesystem::path& sequence, const std::filesystem::path& out,
                      const WorkContext& work);

}  // namespace plumbline
