// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "engine/models/axis_guess.h"
#include "engine/models/shape_measures.h"
#include "engine/models/size_guess.h"

namespace plumbline {
namespace {

constexpr double kStableTilt_rad = 0.26;  ///< 15 degrees are enough.
constexpr double kUnknownThing = 0.8;  ///< What a shape says counts less if nobody says what it is.
constexpr double kOddFiles = 0.03;     ///< Follow no rule at all.

/// How often files of a kind have an axis (x, y, z) point up; x is rare everywhere.
double UpHabit(const SignedAxis& up, const std::string& extension) {
  static constexpr std::array<double, 3> kObj = {0.03, 0.54, 0.43}, kOther = {0.03, 0.37, 0.60};
  return (up.sign > 0 ? 0.9 : 0.1) *
         (extension == ".obj" ? kObj : kOther)[static_cast<std::size_t>(up.axis)];
}

/// Whether the plane that it stands on, with `up` pointing up, goes through the file's origin, as
/// people who make models place them.
bool RestsOnOrigin(const Eigen::AlignedBox3d& bounds, const SignedAxis& up) {
  const double bottom = up.sign > 0 ? bounds.min()[up.axis] : -bounds.max()[up.axis];
  return std::abs(bottom) < 0.015 * bounds.sizes()[up.axis];
}

int DirectionsOnOrigin(const Eigen::AlignedBox3d& bounds) {
  int count = 0;
  for (const int axis : {0, 1, 2}) {
    for (const int sign : {1, -1}) count += RestsOnOrigin(bounds, {axis, sign});
  }
  return count;
}

/// Logarithm of how well the shape stands with `up` pointing up.
class Standing {
 public:
  Standing(const ShapeMeasures& shape, const KnownOfMesh& known)
      : shape_(shape),
        known_(known),
        most_asymmetric_(*std::max_element(shape.asymmetry.begin(), shape.asymmetry.end())),
        most_flat_(*std::max_element(shape.flat_share.begin(), shape.flat_share.end())),
        on_origin_(DirectionsOnOrigin(shape.bounds)) {}

  double Weigh(const SignedAxis& up, Stand& stand) const {
    const auto i = static_cast<std::size_t>(up.axis);
    // A box looks alike upside down and on its back: then its shape says nothing.
    const bool plain_box = most_asymmetric_ < 0.01;
    const double asymmetry =
        plain_box ? 1.0 : std::min(1.0, shape_.asymmetry[i] / (0.6 * most_asymmetric_));
    const double flatness =
        plain_box || !(most_flat_ > 0) ? 1.0 : shape_.flat_share[i] / most_flat_;
    stand = StandOn(shape_, up);
    double weight = 0;
    weight += 2.5 * std::clamp(stand.tipping_rad / kStableTilt_rad, 0.0, 1.0);
    weight += 1.5 * std::max(0.0, 1.0 - stand.imbalance);
    weight += 1.0 * std::min(1.0, 2 * stand.base_share);
    weight += 1.5 * asymmetry + 1.0 * flatness + (stand.has_feet() ? 0.7 : 0.0);
    weight *= known_.thing != nullptr ? 1.0 : kUnknownThing;
    weight += std::log(UpHabit(up, known_.extension));
    if (on_origin_ > 0 && RestsOnOrigin(shape_.bounds, up)) weight += std::log(10.0 / on_origin_);
    if (known_.thing != nullptr)
      weight += LogFitStanding(known_.metres * shape_.bounds.sizes(), up.axis, *known_.thing);
    return weight;
  }

 private:
  const ShapeMeasures& shape_;
  const KnownOfMesh& known_;
  double most_asymmetric_, most_flat_;
  int on_origin_;
};

std::string ReasonOf(const Stand& stand) {
  return std::string("so it stands on ") +
         (stand.has_feet() ? std::to_string(stand.feet) + " feet" : "its base") + " up to " +
         std::to_string(std::lround(stand.tipping_rad * 180 / std::numbers::pi)) +
         " degrees of tilt, its centre " + std::to_string(std::lround(100 * stand.imbalance)) +
         " % of the base's radius off the middle";
}

}  // namespace

Result<Guess<SignedAxis>> GuessUp(const TriangleMesh& mesh, const KnownOfMesh& known,
                                  std::optional<int> only_axis) {
  const Result<ShapeMeasures> shape = MeasureShape(mesh);
  if (!shape.ok()) return shape.error();
  const Standing standing(*shape, known);
  Guess<SignedAxis> guess;
  Stand best, stand;
  double highest = -1e9, sum = 0;
  for (const int axis : {0, 1, 2}) {
    if (only_axis && axis != *only_axis) continue;
    for (const int sign : {1, -1}) {
      const SignedAxis up{axis, sign};
      const double weight = standing.Weigh(up, stand);
      guess.shares.emplace_back(up, std::exp(weight));
      sum += guess.shares.back().second;
      if (weight <= highest) continue;
      highest = weight;
      best = stand;
    }
  }
  const double even = 1.0 / static_cast<double>(guess.shares.size());
  for (auto& [up, share] : guess.shares) share = (1 - kOddFiles) * share / sum + kOddFiles * even;
  std::stable_sort(guess.shares.begin(), guess.shares.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  guess.value = guess.shares[0].first;
  guess.confidence = guess.shares[0].second;
  guess.reason = ReasonOf(best);
  return guess;
}

}  // namespace plumbline
