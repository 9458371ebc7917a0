// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <thread>

namespace plumbline {

/// Ctrl-C (SIGINT) and SIGTERM as a request to end in good order; the second of either ends the
/// program at once. One at a time.
class Interrupts {
 public:
  /// @param asked  Called once at most, from a thread of its own.
  explicit Interrupts(std::function<void()> asked);
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;

 private:
  std::thread watcher_;
};

}  // namespace plumbline
