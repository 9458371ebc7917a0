// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace plumbline {

/// Wall-clock time since construction or the last Lap.
class Stopwatch {
 public:
  double Milliseconds() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }
  /// Milliseconds since the last lap; starts the next.
  double Lap() {
    const double elapsed = Milliseconds();
    start_ = Clock::now();
    return elapsed;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace plumbline
