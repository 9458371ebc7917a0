// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "engine/sensor/imu.h"

namespace plumbline {

/// A line that an IMU sends: `t,wx,wy,wz,ax,ay,az` or, where it has no clock, `wx,wy,wz,ax,ay,az`
/// [s or ns, rad/s, m/s^2]; or as phones stream theirs (Wireless IMU, IMU+GPS-Stream: a stamp [s],
/// then an Android sensor's number and its three values, again and again: 3 is the accelerometer,
/// 4 the gyroscope, others are left out). Between commas, spaces or tabs.
struct ImuLine {
  std::optional<std::int64_t> stamp_ns;  ///< On the IMU's own clock.
  Eigen::Vector3d angular_velocity_rad_s, specific_force_m_s2;
};

/// Nothing for any other text, and where a number is not finite.
std::optional<ImuLine> ParseImuLine(std::string_view line);

/// Carries the stamps of an IMU over to this machine's clock. Whatever delays a reading on its way
/// only adds: the clocks are as far apart as the least that an arrival was later than its stamp. So
/// many readings are looked at for it, then it stays, and stamps keep their steps. How long the
/// least delay itself is stays unknown; that is `time_offset_s`, which the filter estimates.
class ClockCarrier {
 public:
  explicit ClockCarrier(int readings) : wanted_(readings) {}
  /// A reading; by rising arrival. Once enough were seen, it changes nothing more.
  void See(std::int64_t stamp_ns, std::int64_t arrived_ns);
  /// Takes what another has found.
  void Know(std::int64_t offset_ns);
  /// By how much [s] the IMU's clock must have jumped before this reading; 0 where it has not: back
  /// by over a second, or on by a second more than time has passed. Readings that were held up on
  /// their way and come late are no jump.
  double JumpBefore(std::int64_t stamp_ns, std::int64_t arrived_ns) const;
  /// Whether enough were seen.
  bool ready() const { return seen_ >= wanted_; }
  /// As known now [ns]: what a stamp of the IMU is to be added to.
  std::int64_t offset_ns() const { return offset_ns_; }

 private:
  int wanted_, seen_ = 0;
  std::int64_t offset_ns_ = 0;
  struct Reading {
    std::int64_t stamp_ns, arrived_ns;
  };
  std::optional<Reading> last_;
};

}  // namespace plumbline
