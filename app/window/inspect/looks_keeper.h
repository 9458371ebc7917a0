// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "engine/analysis/object_looks.h"

namespace plumbline {

/// The looks of a run's objects, worked out again when it has other events.
class LooksKeeper {
 public:
  std::shared_ptr<const ObjectLooks> Of(const PlaybackView& playback) {
    if (playback.events != events_) {
      events_ = playback.events;
      looks_ = std::make_shared<const ObjectLooks>(LooksOf(*events_));
    }
    return looks_;
  }

 private:
  std::shared_ptr<const std::vector<FrameEvent>> events_;
  std::shared_ptr<const ObjectLooks> looks_;
};

}  // namespace plumbline
