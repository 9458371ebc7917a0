// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/base/progress.h"
#include "engine/base/result.h"

namespace plumbline {

inline constexpr int kDemoFrames = 150;

/// The built-in synthetic sequence of so many frames, in the cache: filmed on first use, complete
/// or not there at all. Errors: kIo, kCancelled.
Result<std::filesystem::path> BuiltInSequence(int frames, const WorkContext& work);

}  // namespace plumbline
