// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/credible_region.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include <Eigen/Cholesky>

#include "engine/base/check.h"
#include "engine/base/random.h"
#include "engine/evaluation/chi_square.h"

namespace plumbline {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
/// Added to every deviation, so that a belief without spread is still a density.
constexpr double kLeastStd = 1e-5;
constexpr int kDraws = 512;
/// A mode whose azimuth spreads over more than this share of its period overlaps its own copies.
constexpr double kNarrow = 0.125;
constexpr int kWindings = 2;

Eigen::Matrix4d WithTruth(const Eigen::Matrix4d& covariance, const TrueState& truth) {
  Eigen::Matrix4d sum = covariance;
  sum.diagonal().head<3>().array() +=
      truth.position_std_m * truth.position_std_m / 3 + kLeastStd * kLeastStd;
  sum(3, 3) += truth.azimuth_std_rad * truth.azimuth_std_rad + kLeastStd * kLeastStd;
  return sum;
}

double Period(int symmetry_order) { return kTwoPi / std::max(1, symmetry_order); }

/// A mode's density over position and azimuth, or over position alone.
class ModeDensity {
 public:
  ModeDensity(const BeliefMode& mode, double weight, const TrueState& truth)
      : weight_(weight),
        mean_(mode.mean),
        order_(mode.symmetry_order),
        truth_order_(truth.symmetry_order),
        num_dimensions_(truth.symmetry_order == 0 || mode.symmetry_order == 0 ? 3 : 4) {
    Eigen::Matrix4d covariance = WithTruth(mode.covariance, truth);
    if (num_dimensions_ == 3) {
      covariance.row(3).setZero();
      covariance.col(3).setZero();
      covariance(3, 3) = 1;  // takes no part
    }
    root_ = covariance.llt().matrixL();
    std_rad_ = num_dimensions_ == 4 ? std::sqrt(covariance(3, 3)) : 0;
    norm_ = std::pow(kTwoPi, -0.5 * num_dimensions_) / root_.diagonal().prod();
  }

  int num_dimensions() const { return num_dimensions_; }
  double weight() const { return weight_; }
  int order() const { return order_; }
  bool narrow() const { return std_rad_ < kNarrow * Period(order_); }

  /// Squared Mahalanobis distance, to the nearest of the mode's equal azimuths.
  double SquaredDistance(const Eigen::Vector4d& state) const {
    Eigen::Vector4d offset = state - mean_;
    offset[3] = num_dimensions_ == 4 ? std::remainder(offset[3], Period(order_)) : 0;
    return root_.triangularView<Eigen::Lower>().solve(offset).squaredNorm();
  }

  /// Density at a state whose azimuth counts modulo the truth's symmetry.
  double At(const Eigen::Vector4d& state) const {
    if (truth_order_ == 0) return Gaussian(state);
    if (order_ == 0) return Gaussian(state) * truth_order_ / kTwoPi;
    if (order_ == truth_order_) return Wound(state);
    double sum = 0;
    Eigen::Vector4d equal = state;
    for (int i = 0; i < truth_order_; ++i) {
      sum += Wound(equal) / order_;
      equal[3] += Period(truth_order_);
    }
    return sum;
  }

  /// The state at standard normal coordinates; `share` in [0, 1) is the azimuth of a round mode.
  Eigen::Vector4d Draw(const Eigen::Vector4d& normal, double share) const {
    Eigen::Vector4d state = mean_ + root_ * normal;
    if (order_ == 0) state[3] = kTwoPi * share;
    return state;
  }

 private:
  double Gaussian(const Eigen::Vector4d& state) const {
    return norm_ * std::exp(-0.5 * SquaredDistance(state));
  }

  /// Sum over the turns of the circle that reach here.
  double Wound(const Eigen::Vector4d& state) const {
    if (narrow()) return Gaussian(state);
    Eigen::Vector4d offset = state - mean_;
    offset[3] = std::remainder(offset[3], Period(order_)) - kWindings * Period(order_);
    double sum = 0;
    for (int i = -kWindings; i <= kWindings; ++i) {
      sum += std::exp(-0.5 * root_.triangularView<Eigen::Lower>().solve(offset).squaredNorm());
      offset[3] += Period(order_);
    }
    return norm_ * sum;
  }

  double weight_;
  Eigen::Vector4d mean_;
  int order_, truth_order_, num_dimensions_;
  Eigen::Matrix4d root_ = Eigen::Matrix4d::Zero();
  double std_rad_ = 0, norm_ = 0;
};

/// Standard normal points, in opposite pairs, whose norms are quantiles of their distribution: a
/// region of one Gaussian gets its probability to 1 / kDraws.
std::vector<Eigen::Vector4d> MakeDraws(int num_dimensions) {
  Random random({.seed = 1});
  std::vector<Eigen::Vector4d> draws;
  for (int i = 0; i < kDraws / 2; ++i) {
    Eigen::Vector4d direction = Eigen::Vector4d::Zero();
    for (int axis = 0; axis < num_dimensions; ++axis) direction[axis] = random.Gaussian();
    const double share = (i + 0.5) / (0.5 * kDraws);
    direction *= std::sqrt(ChiSquareQuantile(share, num_dimensions)) / direction.norm();
    draws.push_back(direction);
    draws.push_back(-direction);
  }
  return draws;
}

const std::vector<Eigen::Vector4d>& Draws(int num_dimensions) {
  static const std::vector<Eigen::Vector4d> three = MakeDraws(3), four = MakeDraws(4);
  return num_dimensions == 3 ? three : four;
}

}  // namespace

double CredibleLevel(std::span<const BeliefMode> modes, const TrueState& truth) {
  double sum = 0;
  for (const BeliefMode& mode : modes) sum += mode.weight;
  PLB_CHECK(sum > 0) << "a belief of " << modes.size() << " modes without weight";
  std::vector<ModeDensity> densities;
  for (const BeliefMode& mode : modes) {
    if (mode.weight > 0) densities.emplace_back(mode, mode.weight / sum, truth);
  }
  const bool round = truth.symmetry_order == 0;
  if (densities.size() == 1 &&
      (round || (densities[0].order() == truth.symmetry_order && densities[0].narrow())))
    return ChiSquareCdf(densities[0].SquaredDistance(truth.state), densities[0].num_dimensions());

  const auto density = [&](const Eigen::Vector4d& state) {
    double value = 0;
    for (const ModeDensity& mode : densities) value += mode.weight() * mode.At(state);
    return value;
  };
  const double at_truth = density(truth.state);
  double level = 0;
  for (const ModeDensity& mode : densities) {
    int likelier = 0, i = 0;
    for (const Eigen::Vector4d& normal : Draws(mode.num_dimensions())) {
      double whole = 0;
      const double share = std::modf(++i * std::numbers::phi, &whole);
      likelier += density(mode.Draw(normal, share)) > at_truth;
    }
    level += mode.weight() * likelier / kDraws;
  }
  return std::min(level, 1.0);
}

Nees NeesOf(const BeliefMode& mode, const TrueState& truth) {
  Eigen::Vector4d offset = truth.state - mode.mean;
  const Eigen::Matrix4d covariance = WithTruth(mode.covariance, truth);
  if (truth.symmetry_order == 0 || mode.symmetry_order == 0) {
    const Eigen::Vector3d place = offset.head<3>();
    return {place.dot(covariance.topLeftCorner<3, 3>().ldlt().solve(place)), 3};
  }
  offset[3] = std::remainder(offset[3], Period(truth.symmetry_order));
  return {offset.dot(covariance.ldlt().solve(offset)), 4};
}

}  // namespace plumbline
