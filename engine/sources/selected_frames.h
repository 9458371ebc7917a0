// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "engine/sources/frame_source.h"

namespace plumbline {

/// The packets of a source without the frames that are not wanted, up to the last that is.
class SelectedFrames : public FrameSource {
 public:
  /// @param source  Outlives this.
  /// @param begin, last, step  Wanted are the frames begin, begin + step .. up to `last`, included.
  SelectedFrames(FrameSource& source, int begin, int last, int step)
      : source_(source), begin_(begin), last_(last), step_(step) {}

  const Calibration& calibration() const override { return source_.calibration(); }
  Result<std::optional<Packet>> Next(const std::stop_token& stop) override {
    while (!ended_) {
      Result<std::optional<Packet>> packet = source_.Next(stop);
      if (!packet.ok() || !packet.value()) return packet;
      const auto* frame = std::get_if<FramePacket>(&**packet);
      if (frame == nullptr) return packet;
      ended_ = frame->frame >= last_;
      if (frame->frame >= begin_ && frame->frame <= last_ && (frame->frame - begin_) % step_ == 0)
        return packet;
    }
    return std::optional<Packet>();
  }

 private:
  FrameSource& source_;
  const int begin_, last_, step_;
  bool ended_ = false;
};

}  // namespace plumbline
