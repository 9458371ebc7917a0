// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "engine/dataset/sequence.h"

namespace plumbline {

/// Decodes the frames that will be asked for next, on a thread of its own, so that playing in order
/// never waits for the disk. At most `ahead` frames ahead and the one given last are kept: memory
/// does not grow with the sequence. Any order of frames is right; a jump only waits for its first
/// frame. Get is to be called from one thread at a time.
class FramePrefetcher {
 public:
  /// @param step   From one frame to the one asked for next, as in `--frames A:B:S`; negative to
  /// play backwards, not 0.
  /// @param ahead  Frames decoded ahead, at least 1.
  explicit FramePrefetcher(std::shared_ptr<const Sequence> sequence, int step = 1, int ahead = 4);
  /// Waits for the frame in decoding, if any.
  ~FramePrefetcher();
  FramePrefetcher(const FramePrefetcher&) = delete;
  FramePrefetcher& operator=(const FramePrefetcher&) = delete;

  /// What Sequence::ReadFrame gives, waiting until it is there. Errors: also kCancelled once `stop`
  /// is requested.
  Result<Frame> Get(int index, const std::stop_token& stop = {});

 private:
  /// Whether `index` may be asked for soon, or was asked for last.
  bool IsNear(int index) const;
  /// The nearest frame that is still to be decoded; -1 if there is none.
  int NextToDecode() const;
  void Run(const std::stop_token& stop);

  const std::shared_ptr<const Sequence> sequence_;
  const int step_;
  const int ahead_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  int position_;  ///< The frame asked for last. Guarded, as all below.
  std::map<int, Result<Frame>> frames_;
  std::jthread thread_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
