// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <stop_token>

#include "engine/base/result.h"
#include "engine/transport/node_client.h"

namespace plumbline {

/// The frames that somebody goes through, of those that a node can be asked for.
struct FramesAhead {
  int begin = 0, end = 0, step = 1;  ///< `end` is not among them.
  int window = 4;                    ///< So many are asked for at once.
};

/// Asks a node for frames, the next ones before they are needed: the window is the credit that the
/// node has, and it can never send more than that. A frame out of turn is asked for by itself. Safe
/// to use from several threads.
class RequestsAhead {
 public:
  /// @param client  Outlives this.
  RequestsAhead(NodeClient& client, const FramesAhead& frames,
                std::function<wire::Request(int frame)> request);

  /// Errors: what the node refused; kCancelled.
  Result<SharedReply> Get(int frame, const std::stop_token& stop);
  /// The same, whatever was said before.
  Result<SharedReply> GetAgain(int frame, const std::stop_token& stop);

 private:
  NodeClient& client_;
  const FramesAhead frames_;
  const std::function<wire::Request(int)> request_;
  std::mutex mutex_;
  std::map<int, std::future<Result<SharedReply>>> asked_;
  int next_;  ///< The one that is in turn.
};

/// The pixels of a frame that a node was asked for; where they were shared and are gone meanwhile
/// (it keeps a few), it is asked again.
/// @param pixels  Takes them out of the reply.
template <typename Take>
auto TakePixels(RequestsAhead& requests, int frame, const std::stop_token& stop, Take take)
    -> decltype(take(*SharedReply())) {
  constexpr int kTries = 5;
  Result<SharedReply> reply = requests.Get(frame, stop);
  for (int i = 0;; ++i) {
    if (!reply.ok()) return reply.error();
    auto taken = take(**reply);
    if (taken.ok() || taken.error().code != ErrorCode::kNotFound || i == kTries) return taken;
    reply = requests.GetAgain(frame, stop);
  }
}

}  // namespace plumbline
