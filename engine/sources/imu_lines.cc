// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/imu_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/dataset/text_table.h"

namespace plumbline {

std::optional<ImuLine> ParseImuLine(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  const std::vector<std::string_view> fields = SplitFields(line);
  if (fields.size() != 6 && fields.size() != 7) return std::nullopt;
  ImuLine reading;
  if (fields.size() == 7) {
    reading.stamp_ns = ParseStampNs(fields[0]);
    if (!reading.stamp_ns) return std::nullopt;
  }
  std::array<double, 6> numbers;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::optional<double> number = ParseNumber(fields[fields.size() - 6 + i]);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    numbers[i] = *number;
  }
  reading.angular_velocity_rad_s = {numbers[0], numbers[1], numbers[2]};
  reading.specific_force_m_s2 = {numbers[3], numbers[4], numbers[5]};
  return reading;
}

void ClockCarrier::See(std::int64_t stamp_ns, std::int64_t arrived_ns) {
  const std::int64_t later_ns = arrived_ns - stamp_ns;
  offset_ns_ = seen_ == 0 ? later_ns : std::min(offset_ns_, later_ns);
  ++seen_;
}

}  // namespace plumbline
