// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/imu_buffer.h"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

/// Steps between readings longer than this many periods are gaps.
constexpr double kGapPeriods = 3.5;
/// Within a gap a hand may do anything: the densities of a phone times this are 0.5 rad/s and
/// 8 m/s^2 in 10 ms.
constexpr double kGapNoise = 300;
constexpr double kSaturatedNoise = 100;
constexpr std::int64_t kGapStepNs = 10'000'000;

double NoiseFactor(ImuFlaw flaw) {
  return flaw == ImuFlaw::kGap ? kGapNoise : flaw == ImuFlaw::kSaturated ? kSaturatedNoise : 1;
}

bool Earlier(const ImuSample& sample, std::int64_t stamp_ns) { return sample.stamp_ns < stamp_ns; }

ImuSample Between(const ImuSample& a, const ImuSample& b, std::int64_t stamp_ns) {
  const double share = static_cast<double>(stamp_ns - a.stamp_ns) /
                       static_cast<double>(std::max<std::int64_t>(b.stamp_ns - a.stamp_ns, 1));
  ImuSample sample;
  sample.stamp_ns = stamp_ns;
  sample.angular_velocity_rad_s =
      a.angular_velocity_rad_s + share * (b.angular_velocity_rad_s - a.angular_velocity_rad_s);
  sample.specific_force_m_s2 =
      a.specific_force_m_s2 + share * (b.specific_force_m_s2 - a.specific_force_m_s2);
  return sample;
}

}  // namespace

ImuBuffer::ImuBuffer(const ImuCalibration& calibration)
    : calibration_(calibration),
      gap_ns_(static_cast<std::int64_t>(kGapPeriods * 1e9 / calibration.rate_hz)),
      vibration_(calibration.rate_hz) {}

bool ImuBuffer::Add(const ImuSample& sample) {
  const bool rises = samples_.empty() || sample.stamp_ns > samples_.back().stamp_ns;
  if (!rises || !sample.angular_velocity_rad_s.allFinite() ||
      !sample.specific_force_m_s2.allFinite()) {
    ++dropped_;
    return false;
  }
  samples_.push_back(sample);
  vibration_.Add(sample);
  return true;
}

void ImuBuffer::DropBefore(std::int64_t stamp_ns) {
  while (samples_.size() > 1 && samples_[1].stamp_ns <= stamp_ns) samples_.pop_front();
}

std::optional<ImuSample> ImuBuffer::At(std::int64_t stamp_ns) const {
  if (samples_.empty()) return std::nullopt;
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), stamp_ns, Earlier);
  ImuSample held;
  if (after == samples_.end()) {
    held = samples_.back();
  } else if (after == samples_.begin()) {
    held = samples_.front();
  } else {
    return plumbline::Between(*std::prev(after), *after, stamp_ns);
  }
  held.stamp_ns = stamp_ns;
  return held;
}

bool ImuBuffer::Saturated(const ImuSample& sample) const {
  const auto reaches = [](const Eigen::Vector3d& v, const std::optional<double>& limit) {
    return limit && v.cwiseAbs().maxCoeff() >= 0.999 * *limit;
  };
  return reaches(sample.angular_velocity_rad_s, calibration_.saturation_gyro_rad_s) ||
         reaches(sample.specific_force_m_s2, calibration_.saturation_accel_m_s2);
}

std::vector<ImuSegment> ImuBuffer::Between(std::int64_t begin_ns, std::int64_t end_ns) const {
  std::vector<ImuSegment> segments;
  if (samples_.empty() || end_ns <= begin_ns) return segments;
  std::vector<ImuSample> knots = {*At(begin_ns)};
  const auto first = std::lower_bound(samples_.begin(), samples_.end(), begin_ns + 1, Earlier);
  const auto last = std::lower_bound(samples_.begin(), samples_.end(), end_ns, Earlier);
  for (auto sample = first; sample < last; ++sample) knots.push_back(*sample);
  knots.push_back(*At(end_ns));
  // A cut inside of a gap begins or ends at a reading that is far away.
  const bool gap_before = first != samples_.end() && first != samples_.begin() &&
                          first->stamp_ns - std::prev(first)->stamp_ns > gap_ns_;
  const bool gap_after =
      last == samples_.end()
          ? end_ns - samples_.back().stamp_ns > gap_ns_
          : last != samples_.begin() && last->stamp_ns - std::prev(last)->stamp_ns > gap_ns_;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const ImuSample& a = knots[i];
    const ImuSample& b = knots[i + 1];
    const bool gap = b.stamp_ns - a.stamp_ns > gap_ns_ || (i == 0 && gap_before) ||
                     (i + 2 == knots.size() && gap_after);
    const auto steps =
        gap ? std::max<std::int64_t>((b.stamp_ns - a.stamp_ns) / kGapStepNs, 1) : std::int64_t{1};
    const ImuFlaw flaw = gap                            ? ImuFlaw::kGap
                         : Saturated(a) || Saturated(b) ? ImuFlaw::kSaturated
                                                        : ImuFlaw::kNone;
    for (std::int64_t step = 0; step < steps; ++step) {
      const auto at = [&](std::int64_t k) {
        return plumbline::Between(a, b, a.stamp_ns + (b.stamp_ns - a.stamp_ns) * k / steps);
      };
      const ImuSample from = at(step), to = at(step + 1);
      segments.push_back({from.stamp_ns, to.stamp_ns,
                          (from.angular_velocity_rad_s + to.angular_velocity_rad_s) / 2,
                          (from.specific_force_m_s2 + to.specific_force_m_s2) / 2,
                          NoiseFactor(flaw), flaw});
    }
  }
  return segments;
}

}  // namespace plumbline
