// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/console_work.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace plumbline {
namespace {

std::string Duration(double seconds) {
  const int whole = static_cast<int>(std::lround(seconds));
  if (whole < 60) return std::to_string(whole) + " s";
  if (whole < 3600) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min";
}

}  // namespace

ConsoleWork::ConsoleWork()
    : interrupts_([stop = stop_]() mutable { stop.request_stop(); }),
      terminal_(::isatty(STDERR_FILENO) == 1) {}

ConsoleWork::~ConsoleWork() {
  if (line_open_) std::fputc('\n', stderr);
}

WorkContext ConsoleWork::context() {
  return {.report = [this](const Progress& progress) { Report(progress); },
          .stop = stop_.get_token()};
}

void ConsoleWork::Report(const Progress& progress) {
  const Clock::time_point now = Clock::now();
  if (progress.stage != stage_) {
    if (line_open_) std::fputc('\n', stderr);
    line_open_ = false;
    stage_ = progress.stage;
    stage_start_ = last_report_ = now;
  }
  const std::chrono::duration<double> pause(terminal_ ? 0.1 : 5.0);
  const bool finished = progress.total > 0 && progress.done >= progress.total;
  if (now - last_report_ < pause && !(finished && (line_open_ || terminal_))) return;
  last_report_ = now;
  std::string line = stage_ + " " + std::to_string(progress.done);
  if (progress.total > 0) {
    line += " of " + std::to_string(progress.total);
    const double elapsed = std::chrono::duration<double>(now - stage_start_).count();
    if (progress.done > 0 && !finished) {
      line += ", " + Duration(elapsed / progress.done * (progress.total - progress.done)) + " left";
    } else if (finished) {
      line += " in " + Duration(elapsed);
    }
  }
  if (terminal_) {
    std::fprintf(stderr, "\r%s\x1b[K", line.c_str());
  } else {
    std::fprintf(stderr, "%s\n", line.c_str());
  }
  std::fflush(stderr);
  line_open_ = terminal_;
}

}  // namespace plumbline
