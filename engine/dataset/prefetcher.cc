// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/prefetcher.h"

#include <exception>
#include <string>

#include "engine/base/check.h"

namespace plumbline {
namespace {

/// A decoder that runs out of memory must not take the program with it.
Result<Frame> ReadFrameSafely(const Sequence& sequence, int index) {
  try {
    return sequence.ReadFrame(index);
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kIo, "cannot read frame " + std::to_string(index) + " of '" +
                                     sequence.path().string() + "': " + exception.what()};
  }
}

}  // namespace

FramePrefetcher::FramePrefetcher(std::shared_ptr<const Sequence> sequence, int step, int ahead)
    : sequence_(std::move(sequence)),
      step_(step),
      ahead_(ahead),
      position_(step > 0 ? 0 : sequence_->num_frames() - 1) {
  PLB_CHECK(step != 0 && ahead >= 1);
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

FramePrefetcher::~FramePrefetcher() = default;

bool FramePrefetcher::IsNear(int index) const {
  const int steps = (index - position_) / step_;
  return (index - position_) % step_ == 0 && steps >= 0 && steps <= ahead_;
}

int FramePrefetcher::NextToDecode() const {
  for (int i = 0; i <= ahead_; ++i) {
    const int index = position_ + i * step_;
    if (index < 0 || index >= sequence_->num_frames()) return -1;
    if (!frames_.contains(index)) return index;
  }
  return -1;
}

void FramePrefetcher::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return NextToDecode() >= 0; })) {
    const int index = NextToDecode();
    lock.unlock();
    Result<Frame> frame = ReadFrameSafely(*sequence_, index);
    lock.lock();
    if (IsNear(index)) frames_.insert_or_assign(index, std::move(frame));
    changed_.notify_all();
  }
}

Result<Frame> FramePrefetcher::Get(int index, const std::stop_token& stop) {
  PLB_CHECK(index >= 0 && index < sequence_->num_frames())
      << "frame " << index << " of " << sequence_->num_frames();
  std::unique_lock lock(mutex_);
  position_ = index;
  std::erase_if(frames_, [this](const auto& entry) { return !IsNear(entry.first); });
  changed_.notify_all();
  if (!changed_.wait(lock, stop, [&] { return frames_.contains(index); })) {
    return Error{ErrorCode::kCancelled, "waiting for a frame was cancelled"};
  }
  return frames_.at(index);
}

}  // namespace plumbline
