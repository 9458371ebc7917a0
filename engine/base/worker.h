// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <thread>
#include <type_traits>
#include <utility>

#include "engine/base/queue.h"

namespace plumbline {

/// One thread that does what it is given, one after another, in order. The destructor waits until
/// all of it is done.
class Worker {
 public:
  Worker() : thread_([this] { Work(); }) {}
  ~Worker() { tasks_.Close(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// The future gives what `task` returned or threw. Waits for room where much is waiting already.
  template <typename Task>
  std::future<std::invoke_result_t<Task>> Do(Task task) {
    using Promised = std::packaged_task<std::invoke_result_t<Task>()>;
    const auto promised = std::make_shared<Promised>(std::move(task));
    auto future = promised->get_future();
    tasks_.Push([promised] { (*promised)(); });
    return future;
  }

 private:
  static constexpr std::size_t kMostWaiting = 64;

  void Work() {
    while (const auto task = tasks_.Pop()) (*task)();
  }

  BoundedQueue<std::function<void()>> tasks_{kMostWaiting};
  std::jthread thread_;  ///< Last: stops before what it uses goes.
};

}  // namespace plumbline
