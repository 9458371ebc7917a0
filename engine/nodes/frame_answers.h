// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "engine/base/result.h"

namespace plumbline {

/// What a node has made of its last frames, for whoever asks next: several ask for the same image,
/// and those who lost their connection ask again. Safe to use from several threads.
template <typename Value>
class FrameAnswers {
 public:
  explicit FrameAnswers(std::size_t most) : most_(most) {}

  /// What is kept of a frame, or null.
  std::shared_ptr<Value> Known(int frame) {
    const std::lock_guard lock(mutex_);
    const auto known = kept_.find(frame);
    if (known == kept_.end()) return nullptr;
    known->second.used = ++clock_;
    return known->second.value;
  }

  /// What is kept of the frame, or what `make` gives, which is then kept unless it is an error.
  /// From one thread at a time, so that nothing is made twice.
  template <typename Make>
  Result<std::shared_ptr<Value>> Of(int frame, Make make) {
    if (auto known = Known(frame); known != nullptr) return known;
    Result<std::shared_ptr<Value>> made = make();
    if (!made.ok()) return made;
    const std::lock_guard lock(mutex_);
    if (kept_.size() >= most_) {
      auto oldest = kept_.begin();
      for (auto one = kept_.begin(); one != kept_.end(); ++one)
        if (one->second.used < oldest->second.used) oldest = one;
      kept_.erase(oldest);
    }
    kept_[frame] = {*made, ++clock_};
    return made;
  }

 private:
  struct Kept {
    std::shared_ptr<Value> value;
    std::uint64_t used = 0;
  };
  const std::size_t most_;
  std::mutex mutex_;
  std::map<int, Kept> kept_;
  std::uint64_t clock_ = 0;
};

}  // namespace plumbline
