// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/requests_ahead.h"

namespace plumbline {

RequestsAhead::RequestsAhead(NodeClient& client, const FramesAhead& frames,
                             std::function<wire::Request(int frame)> request)
    : client_(client), frames_(frames), request_(std::move(request)), next_(frames.begin) {}

Result<SharedReply> RequestsAhead::Get(int frame, const std::stop_token& stop) {
  std::future<Result<SharedReply>> reply;
  {
    const std::lock_guard lock(mutex_);
    const bool on_grid = (frame - frames_.begin) % frames_.step == 0;
    if (const auto asked = asked_.find(frame); asked != asked_.end()) {
      reply = std::move(asked->second);
      asked_.erase(asked);
      next_ = frame + frames_.step;
    } else {
      reply = client_.Ask(request_(frame));
      // Somebody starts over or passes frames over: what was asked for ahead is of no use.
      if (frame >= next_ && on_grid) {
        asked_.clear();
        next_ = frame + frames_.step;
      }
    }
    const int last = next_ + (frames_.window - 1) * frames_.step;
    const bool in_turn = next_ == frame + frames_.step;
    for (int ahead = next_; in_turn && ahead < last && ahead < frames_.end; ahead += frames_.step)
      if (!asked_.contains(ahead)) asked_.emplace(ahead, client_.Ask(request_(ahead)));
    asked_.erase(asked_.begin(), asked_.lower_bound(next_));
  }
  return WaitFor(reply, stop);
}

Result<SharedReply> RequestsAhead::GetAgain(int frame, const std::stop_token& stop) {
  return client_.AskAndWait(request_(frame), stop);
}

}  // namespace plumbline
