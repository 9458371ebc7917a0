// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>

namespace plumbline {

/// When to take the next image from a live source, so that it is made ready just as its consumer is
/// done with the one before: sooner it would wait and grow old, later the consumer would wait. Goes
/// by how long both took last time; a consumer that waits is never kept waiting for longer than
/// making an image ready takes. One image at most waits for the consumer. For two threads: the
/// maker calls WaitToTake and Made, the consumer the others.
class LivePace {
 public:
  using Clock = std::chrono::steady_clock;

  /// The consumer is done with what it had, and wants the next.
  void Asked(Clock::time_point now = Clock::now()) {
    const std::lock_guard lock(mutex_);
    waiting_ = true;
    if (given_) using_ = now - *given_;
    changed_.notify_all();
  }
  /// The consumer has what it asked for.
  void Given(Clock::time_point now = Clock::now()) {
    const std::lock_guard lock(mutex_);
    waiting_ = false;
    unused_ = false;
    given_ = now;
    changed_.notify_all();
  }
  /// An image is ready; making it so took so long, waiting for it to come not included.
  void Made(Clock::duration took) {
    const std::lock_guard lock(mutex_);
    making_ = took;
    unused_ = true;
  }
  /// When to take the next image unless the consumer asks before.
  Clock::time_point TakeAt() const {
    const std::lock_guard lock(mutex_);
    return TakeAtLocked();
  }
  /// Waits until then, first of all until the consumer has the image before. False once `stop` is
  /// requested.
  bool WaitToTake(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return !unused_; });
    changed_.wait_until(lock, stop, TakeAtLocked(), [&] { return waiting_; });
    return !stop.stop_requested();
  }

 private:
  Clock::time_point TakeAtLocked() const {
    if (!given_) return Clock::time_point();
    return *given_ + std::max(using_ - making_, Clock::duration::zero());
  }

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  bool waiting_ = false;  ///< The consumer.
  bool unused_ = false;   ///< An image that is ready.
  std::optional<Clock::time_point> given_;
  Clock::duration using_{}, making_{};
};

}  // namespace plumbline
