// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <stop_token>
#include <string>

#include "app/platform/interrupts.h"
#include "engine/base/progress.h"

namespace plumbline {

/// What a command gives to long work: progress with the time left on standard error (one line that
/// is rewritten on a terminal, a plain line every few seconds otherwise) and Ctrl-C as a request to
/// stop. A second Ctrl-C ends the program at once. One at a time; `context()` must not outlive it.
class ConsoleWork {
 public:
  ConsoleWork();
  ~ConsoleWork();
  ConsoleWork(const ConsoleWork&) = delete;
  ConsoleWork& operator=(const ConsoleWork&) = delete;

  WorkContext context();
  /// Whether Ctrl-C was pressed.
  bool interrupted() const { return stop_.stop_requested(); }

 private:
  using Clock = std::chrono::steady_clock;
  void Report(const Progress& progress);

  std::stop_source stop_;
  Interrupts interrupts_;
  bool terminal_;
  bool line_open_ = false;
  std::string stage_;
  Clock::time_point stage_start_;
  Clock::time_point last_report_;
};

}  // namespace plumbline
