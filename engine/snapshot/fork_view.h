// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace plumbline {

enum class ForkState { kIdle, kRunning, kDone, kCancelled, kFailed };

/// How far the fork of a run is.
struct ForkView {
  ForkState state = ForkState::kIdle;
  std::string out;      ///< The new run file.
  std::string message;  ///< What it does now, or what went wrong.
  int done = 0, total = 0;
};

}  // namespace plumbline
