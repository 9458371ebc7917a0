// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stop_token>
#include <string_view>

namespace plumbline {

/// How far long work is: `done` of `total` steps of `stage` (total 0: unknown).
struct Progress {
  std::string_view stage;
  int done = 0;
  int total = 0;
};

/// What long work is given: somebody to tell, and a way to be asked to stop. Loops look at `stop`
/// at least every 50 ms and then return kCancelled, keeping what is done.
struct WorkContext {
  std::function<void(const Progress&)> report = [](const Progress&) {};
  std::stop_token stop = {};
};

}  // namespace plumbline
