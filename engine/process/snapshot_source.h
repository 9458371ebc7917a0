// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stop_token>
#include <vector>

#include "engine/base/result.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

/// Where the frames of the window come from: a mapper at work on a sequence, or a run file. Used
/// from one thread.
class SnapshotSource {
 public:
  virtual ~SnapshotSource() = default;

  virtual const SequenceView& view() const = 0;
  /// First frame there is, and the last one there will be.
  virtual int first_frame() const = 0;
  virtual int last_frame() const = 0;
  /// The newest frame that Past can give; first_frame() - 1 before the first.
  virtual int newest_frame() const = 0;
  /// Nothing is mapped here: every frame is a past one.
  virtual bool recorded() const = 0;

  /// Maps the frame after the newest. Errors: what went wrong, kCancelled once `stop` is asked for
  /// (within 50 ms).
  virtual Result<std::shared_ptr<const MapSnapshot>> Next(std::stop_token stop) = 0;
  /// A frame first_frame() .. newest_frame() as it was when it was mapped.
  virtual Result<std::shared_ptr<const MapSnapshot>> Past(int frame, std::stop_token stop) = 0;
  /// Life events of the frames up to newest_frame(), by frame.
  virtual const std::vector<FrameEvent>& events() const = 0;
};

}  // namespace plumbline
