// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "engine/batch/batch_engines.h"

namespace plumbline {
namespace {

/// The runs of a batch, handed to several threads.
class LocalQueue {
 public:
  LocalQueue(const Batch& batch, const PendingJobs& jobs, const WorkContext& work)
      : batch_(batch), jobs_(jobs), work_(work) {}

  /// Takes runs until there is none left.
  void Work() {
    while (!work_.stop.stop_requested()) {
      const std::size_t i = next_++;
      if (i >= jobs_.size()) break;
      const Status status = RunJob(batch_, *jobs_[i], work_.stop);
      const std::lock_guard lock(mutex_);
      ++done_;
      if (!status.ok() && status_.ok()) status_ = status;
      changed_.notify_one();
    }
    const std::lock_guard lock(mutex_);
    ++idle_;
    changed_.notify_one();
  }

  /// Tells how far they are until `threads` of them have ended.
  Status Wait(int threads) {
    std::unique_lock lock(mutex_);
    while (idle_ < threads) {
      changed_.wait_for(lock, std::chrono::milliseconds(100));
      work_.report({"running", done_, static_cast<int>(jobs_.size())});
    }
    if (work_.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    return status_;
  }

 private:
  const Batch& batch_;
  const PendingJobs& jobs_;
  const WorkContext& work_;
  std::atomic<std::size_t> next_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  int done_ = 0, idle_ = 0;
  Status status_;
};

}  // namespace

PendingJobs PendingJobsOf(const Batch& batch) {
  PendingJobs pending;
  for (const BatchJob& job : batch.jobs) {
    if (!ReadJobResult(batch, job)) pending.push_back(&job);
  }
  return pending;
}

Status RunHere(const Batch& batch, const PendingJobs& jobs, int at_once, const WorkContext& work) {
  LocalQueue queue(batch, jobs, work);
  at_once = std::min(at_once, static_cast<int>(jobs.size()));
  std::vector<std::jthread> threads;
  for (int i = 0; i < at_once; ++i) threads.emplace_back([&queue] { queue.Work(); });
  return queue.Wait(at_once);
}

}  // namespace plumbline
