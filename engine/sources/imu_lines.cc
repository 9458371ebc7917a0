// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/imu_lines.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "engine/dataset/text_table.h"

namespace plumbline {

namespace {

std::optional<Eigen::Vector3d> VectorOf(std::span<const std::string_view> fields) {
  Eigen::Vector3d vector;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::optional<double> number = ParseNumber(fields[i]);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    vector[static_cast<Eigen::Index>(i)] = *number;
  }
  return vector;
}

/// Of a phone; nothing where it lacks one of the two.
std::optional<ImuLine> PhoneLine(std::span<const std::string_view> fields) {
  const std::optional<std::int64_t> stamp_ns = ParseStampNs(fields[0]);
  std::optional<Eigen::Vector3d> gyroscope, accelerometer;
  for (std::size_t i = 1; i + 3 < fields.size(); i += 4) {
    if (fields[i] == "3") accelerometer = VectorOf(fields.subspan(i + 1, 3));
    if (fields[i] == "4") gyroscope = VectorOf(fields.subspan(i + 1, 3));
  }
  if (!stamp_ns || !gyroscope || !accelerometer) return std::nullopt;
  return ImuLine{stamp_ns, *gyroscope, *accelerometer};
}

}  // namespace

std::optional<ImuLine> ParseImuLine(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  const std::vector<std::string_view> all = SplitFields(line);
  const std::span<const std::string_view> fields(all);
  if (fields.size() >= 9 && fields.size() % 4 == 1) return PhoneLine(fields);
  if (fields.size() != 6 && fields.size() != 7) return std::nullopt;
  ImuLine reading;
  if (fields.size() == 7) {
    reading.stamp_ns = ParseStampNs(fields[0]);
    if (!reading.stamp_ns) return std::nullopt;
  }
  const auto angular = VectorOf(fields.last(6).first(3)), force = VectorOf(fields.last(3));
  if (!angular || !force) return std::nullopt;
  reading.angular_velocity_rad_s = *angular;
  reading.specific_force_m_s2 = *force;
  return reading;
}

void ClockCarrier::See(std::int64_t stamp_ns, std::int64_t arrived_ns) {
  last_ = {stamp_ns, arrived_ns};
  if (ready()) return;
  const std::int64_t later_ns = arrived_ns - stamp_ns;
  offset_ns_ = seen_ == 0 ? later_ns : std::min(offset_ns_, later_ns);
  ++seen_;
}

void ClockCarrier::Know(std::int64_t offset_ns) {
  offset_ns_ = offset_ns;
  seen_ = wanted_;
}

double ClockCarrier::JumpBefore(std::int64_t stamp_ns, std::int64_t arrived_ns) const {
  constexpr std::int64_t kJump = 1'000'000'000;
  std::int64_t jump_ns = 0;
  if (last_) {
    const std::int64_t step_ns = stamp_ns - last_->stamp_ns;
    if (step_ns < -kJump) jump_ns = step_ns;
    if (step_ns > arrived_ns - last_->arrived_ns + kJump)
      jump_ns = step_ns - (arrived_ns - last_->arrived_ns);
  } else if (ready()) {
    // Of what somebody else has found: nothing comes before it was sent, nor very late.
    const std::int64_t early_ns = stamp_ns + offset_ns_ - arrived_ns;
    if (early_ns > kJump || early_ns < -20 * kJump) jump_ns = early_ns;
  }
  return 1e-9 * static_cast<double>(jump_ns);
}

}  // namespace plumbline
