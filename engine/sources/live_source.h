// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

#include "engine/dataset/growing_recording.h"
#include "engine/sources/frame_source.h"
#include "engine/sources/live_report.h"

namespace plumbline {

/// The time by which a recording is played.
class LiveClock {
 public:
  virtual ~LiveClock() = default;
  /// Never falls.
  virtual std::int64_t NowNs() const = 0;
  /// Returns at that time, or once `stop` is requested.
  virtual void WaitUntil(std::int64_t time_ns, const std::stop_token& stop) = 0;
};

/// The machine's.
std::shared_ptr<LiveClock> SteadyLiveClock();

/// Plays a recorded source by the clock, as a camera would give it: a frame comes when as much time
/// has passed since the first call of Next as its stamp is after the first one's. Next gives the
/// newest frame that has come and waits where none has; those before it are passed over and
/// counted, the last is always given. What is no frame is never lost: all of it comes in order,
/// with the frame that follows. A stamp that does not rise comes with the frame before it.
///
/// Of a recording that grows a frame comes when it is recorded.
///
/// What is given depends on how fast the consumer is: nothing here can be repeated.
class LiveSource : public FrameSource {
 public:
  /// @param recorded  Does not wait for anything; outlives this.
  /// @param speed  Times as fast as recorded, > 0.
  LiveSource(FrameSource& recorded, double speed,
             std::shared_ptr<LiveClock> clock = SteadyLiveClock());

  /// @param recorded  Waits for frames that are not recorded yet; outlives this.
  /// @param growing  What is recorded; outlives this. @param step  From one frame of `recorded` to
  /// its next.
  LiveSource(FrameSource& recorded, const GrowingRecording& growing, int step);

  const Calibration& calibration() const override { return recorded_.calibration(); }
  Result<std::optional<Packet>> Next(const std::stop_token& stop) override;

  /// The consumer is done with a frame that it was given, and with all before it: for the report.
  /// Safe to call from any thread.
  void Done(int frame);
  /// Safe to call from any thread.
  LiveReport report() const;

 private:
  /// All packets up to a frame, which is the last of them, or to the end of the recording.
  struct Stretch {
    std::deque<Packet> packets;
    std::optional<std::int64_t> comes_ns;  ///< Nothing: no frame, it is the end.
    std::optional<Error> error;            ///< That ended the recording.
  };
  Stretch Read(const std::stop_token& stop);
  /// The next stretch where reading it does not have to wait for a recording that grows.
  std::optional<Stretch> ReadWhatCame(const std::stop_token& stop);
  std::int64_t ComesAt(const FramePacket& frame);
  void Take(Stretch newest);
  void PassOver(Stretch older, Stretch& newer);

  FrameSource& recorded_;
  const GrowingRecording* growing_ = nullptr;
  const int step_ = 1;
  const double speed_;
  const std::shared_ptr<LiveClock> clock_;
  std::deque<Packet> ready_;     ///< Given next.
  std::optional<Stretch> read_;  ///< Read ahead; its frame may not have come yet.
  int last_read_ = -1;           ///< Frame.
  std::optional<std::int64_t> first_stamp_ns_;
  std::int64_t start_ns_ = 0, newest_ns_ = 0;  ///< By the clock: the first and the newest frame.

  mutable std::mutex mutex_;  ///< Of what follows.
  LiveReport report_;
  std::deque<std::pair<int, std::int64_t>> at_work_;  ///< Frames given, and when they came.
};

}  // namespace plumbline
