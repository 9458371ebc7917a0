// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "engine/sensor/imu.h"

namespace plumbline {

class Sequence;

/// Images that come so much later say that an IMU which is waited for has fallen silent.
inline constexpr std::int64_t kSilentImu_ns = 500'000'000;

/// What a sequence is besides while it is being recorded: its frames and the readings of its IMU
/// become more. num_frames() are those that have come. Functions are safe to call from several
/// threads.
class GrowingRecording {
 public:
  virtual ~GrowingRecording() = default;

  /// Whether the image is there.
  virtual bool HasFrame(int frame) const = 0;
  /// Waits until it is. False: the recording ended without it, or `stop` is requested.
  virtual bool WaitForFrame(int frame, const std::stop_token& stop) const = 0;
  /// Waits until the IMU has been read beyond a time on its own clock; until images have come that
  /// are kSilentImu_ns later; or until the recording has ended.
  /// @return the readings from number `from` on.
  virtual std::vector<ImuSample> WaitForImu(std::size_t from, std::int64_t time_ns,
                                            const std::stop_token& stop) const = 0;
  /// When the image came, by the machine's steady clock.
  virtual std::int64_t CameNs(int frame) const = 0;
  /// Whether nothing will come any more.
  virtual bool ended() const = 0;
};

/// The same sequence; null where it is not one that grows.
const GrowingRecording* GrowingRecordingOf(const Sequence& sequence);

}  // namespace plumbline
