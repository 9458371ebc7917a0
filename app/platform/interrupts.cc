// SPDX-License-Identifier: Apache-2.0
#include "app/platform/interrupts.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "engine/base/check.h"

namespace plumbline {
namespace {

// The handler may only write to the pipe; the watcher turns the byte into a call.
int interrupt_pipe[2] = {-1, -1};

void OnInterrupt(int) {
  const char byte = 'i';
  [[maybe_unused]] const auto written = ::write(interrupt_pipe[1], &byte, 1);
}

}  // namespace

Interrupts::Interrupts(std::function<void()> asked) {
  PLB_CHECK(interrupt_pipe[0] < 0) << "one Interrupts at a time";
  PLB_CHECK(::pipe2(interrupt_pipe, O_CLOEXEC) == 0) << "errno " << errno;
  watcher_ = std::thread([asked = std::move(asked)] {
    char byte = 0;
    while (::read(interrupt_pipe[0], &byte, 1) < 0 && errno == EINTR) continue;
    if (byte == 'i') asked();
  });
  struct sigaction action = {};
  action.sa_handler = OnInterrupt;
  action.sa_flags = SA_RESETHAND | SA_RESTART;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

Interrupts::~Interrupts() {
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGTERM, SIG_DFL);
  const char byte = 'q';
  [[maybe_unused]] const auto written = ::write(interrupt_pipe[1], &byte, 1);
  watcher_.join();
  for (int& end : interrupt_pipe) {
    ::close(end);
    end = -1;
  }
}

}  // namespace plumbline
