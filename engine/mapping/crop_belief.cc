// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/crop_belief.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

constexpr double kTurn_rad = 0.5 * std::numbers::pi;
/// Share of the way to the next turn up to which the nearer one holds alone.
constexpr double kCropPlateau = 1.0 / 3;

}  // namespace

std::vector<CropBelief::Candidate> CropBelief::Candidates(std::span<const ModelId> labels,
                                                          double azimuth_rad) const {
  const double anchor = sums_.empty() ? azimuth_rad : anchor_rad_;
  std::vector<Candidate> candidates;
  for (const ModelId label : labels)
    for (std::size_t turn = 0; turn < kTurns; ++turn)
      candidates.push_back({label, WrapAngle(anchor + static_cast<double>(turn) * kTurn_rad)});
  return candidates;
}

void CropBelief::Add(const Eigen::Isometry3d& world_from_cam, std::span<const ModelId> labels,
                     double azimuth_rad, std::span<const std::optional<double>> likeness) {
  looked_from_.push_back(world_from_cam);
  if (std::any_of(likeness.begin(), likeness.end(), [](const auto& one) { return !one; })) return;
  if (sums_.empty()) {
    anchor_rad_ = azimuth_rad;
    for (const ModelId label : labels) sums_.push_back({label, {}});
  }
  for (std::size_t i = 0; i < likeness.size(); ++i)
    sums_.at(i / kTurns).of_turn.at(i % kTurns) += *likeness[i];
  ++views_;
}

double CropBelief::Likeness(ModelId label, double azimuth_rad) const {
  if (sums_.empty()) return 0;
  double best = sums_.front().of_turn.front(), least = best;
  const Sum* of_label = nullptr;
  for (const Sum& sum : sums_) {
    const auto [low, high] = std::minmax_element(sum.of_turn.begin(), sum.of_turn.end());
    best = std::max(best, *high);
    least = std::min(least, *low);
    if (sum.label == label) of_label = &sum;
  }
  if (of_label == nullptr) return least - best;
  const double turns = WrapAngle(azimuth_rad - anchor_rad_) / kTurn_rad + kTurns;  // 2 .. 6
  const double below = std::floor(turns);
  const double on = std::clamp((turns - below - kCropPlateau) / (1 - 2 * kCropPlateau), 0.0, 1.0);
  const auto turn = static_cast<std::size_t>(below);
  const double at_below = of_label->of_turn.at(turn % kTurns);
  const double at_above = of_label->of_turn.at((turn + 1) % kTurns);
  return (1 - on) * at_below + on * at_above - best;
}

void CropBelief::Save(ByteWriter& out) const {
  out.Put(anchor_rad_);
  out.Put(static_cast<std::uint32_t>(sums_.size()));
  for (const Sum& sum : sums_) {
    out.Put(sum.label.value);
    for (const double value : sum.of_turn) out.Put(value);
  }
  out.Put(views_);
  out.Put(static_cast<std::uint32_t>(looked_from_.size()));
  for (const Eigen::Isometry3d& pose : looked_from_) out.Put(pose);
}

void CropBelief::Restore(ByteReader& in) {
  anchor_rad_ = in.Get<double>();
  const auto count = in.Get<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
    Sum sum;
    sum.label.value = in.Get<std::int32_t>();
    for (double& value : sum.of_turn) value = in.Get<double>();
    sums_.push_back(sum);
  }
  views_ = in.Get<int>();
  const auto looks = in.Get<std::uint32_t>();
  for (std::uint32_t i = 0; i < looks && in.ok(); ++i) looked_from_.push_back(in.GetPose());
}

}  // namespace plumbline
