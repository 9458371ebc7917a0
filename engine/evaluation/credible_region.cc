// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/credible_region.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <boost/math/special_functions/beta.hpp>

#include "engine/base/check.h"
#include "engine/base/random.h"
#include "engine/evaluation/chi_square.h"

namespace plumbline {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
/// Added to every deviation, so that a belief without spread is still a density.
constexpr double kLeastStd = 1e-5;
constexpr int kDraws = 512;
constexpr int kNormalsOfT = 8;  ///< Its distribution within 0.004, its last 2 % within 0.01.
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

/// One of the Gaussians with a common mean that together are Student's t.
struct ScaledNormal {
  double share = 1;
  double precision = 1;  ///< Times that of the whole.
};

/// Student's t is a normal whose precision is itself unknown, with a Gamma distribution of the
/// shape dof / 2, here scaled so that the mean variance is 1: by Gauss-Laguerre quadrature (Golub
/// and Welsch, Mathematics of Computation 23, 1969).
std::vector<ScaledNormal> NormalsOf(double degrees_of_freedom) {
  if (degrees_of_freedom == 0) return {ScaledNormal{}};
  PLB_CHECK(degrees_of_freedom > 2) << degrees_of_freedom << " degrees have no covariance";
  const double power = degrees_of_freedom / 2 - 1;
  Eigen::VectorXd diagonal(kNormalsOfT), beside(kNormalsOfT - 1);
  for (int i = 0; i < kNormalsOfT; ++i) diagonal[i] = 2 * i + 1 + power;
  for (int i = 1; i < kNormalsOfT; ++i) beside[i - 1] = std::sqrt(i * (i + power));
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside, Eigen::ComputeEigenvectors);
  std::vector<ScaledNormal> normals;
  for (int i = 0; i < kNormalsOfT; ++i) {
    const double first = solver.eigenvectors()(0, i);
    normals.push_back({first * first, solver.eigenvalues()[i] / power});
  }
  return normals;
}

/// The density over position and azimuth, or over position alone, of one Gaussian of a mode.
class ModeDensity {
 public:
  ModeDensity(const BeliefMode& mode, double precision, double weight, const TrueState& truth)
      : weight_(weight),
        mean_(mode.mean),
        order_(mode.symmetry_order),
        truth_order_(truth.symmetry_order),
        num_dimensions_(truth.symmetry_order == 0 || mode.symmetry_order == 0 ? 3 : 4) {
    Eigen::Matrix4d covariance = WithTruth(mode.covariance / precision, truth);
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

/// The Gaussians of one mode, whose weights sum to that of the mode.
using ModeParts = std::vector<ModeDensity>;

std::vector<ModeParts> PartsOf(std::span<const BeliefMode> modes, const TrueState& truth) {
  double sum = 0;
  for (const BeliefMode& mode : modes) sum += mode.weight;
  std::vector<ModeParts> parts;
  for (const BeliefMode& mode : modes) {
    if (!(mode.weight > 0)) continue;
    ModeParts& of_mode = parts.emplace_back();
    for (const ScaledNormal& normal : NormalsOf(mode.degrees_of_freedom))
      of_mode.emplace_back(mode, normal.precision, mode.weight / sum * normal.share, truth);
  }
  return parts;
}

/// The level where a single mode's regions of the highest density are ellipsoids.
std::optional<double> LevelOfOne(std::span<const BeliefMode> modes, const TrueState& truth) {
  const BeliefMode* mode = nullptr;
  for (const BeliefMode& of : modes) {
    if (!(of.weight > 0)) continue;
    if (mode != nullptr) return std::nullopt;
    mode = &of;
  }
  PLB_CHECK(mode != nullptr) << "a belief of " << modes.size() << " modes without weight";
  const double dof = mode->degrees_of_freedom;
  const bool exact = truth.position_std_m == 0 && truth.azimuth_std_rad == 0;
  if (dof > 0 && !exact) return std::nullopt;
  const ModeDensity density(*mode, 1, 1, truth);
  if (truth.symmetry_order != 0 && (density.order() != truth.symmetry_order || !density.narrow()))
    return std::nullopt;
  const double squared = density.SquaredDistance(truth.state);
  if (dof == 0) return ChiSquareCdf(squared, density.num_dimensions());
  const double scaled = squared / (dof - 2);  // the F distribution as an incomplete beta function
  return boost::math::ibeta(0.5 * density.num_dimensions(), 0.5 * dof, scaled / (1 + scaled));
}

double FractionOf(double number) {
  double whole = 0;
  return std::modf(number, &whole);
}

/// The part whose share of the mode's weight a number in [0, 1) falls into.
const ModeDensity& PartAt(const ModeParts& mode, double share) {
  double left = 0;
  for (const ModeDensity& part : mode) left += share * part.weight();
  std::size_t i = 0;
  while (i + 1 < mode.size() && left >= mode[i].weight()) left -= mode[i++].weight();
  return mode[i];
}

/// Share of the draws of each mode that are likelier than the truth; modes share the draws.
double DrawnLevel(std::span<const ModeParts> modes, const TrueState& truth) {
  const auto density_at = [&](const Eigen::Vector4d& state) {
    double sum = 0;
    for (const ModeParts& mode : modes) {
      for (const ModeDensity& part : mode) sum += part.weight() * part.At(state);
    }
    return sum;
  };
  const double at_truth = density_at(truth.state);
  double level = 0;
  for (const ModeParts& mode : modes) {
    double weight = 0;
    for (const ModeDensity& part : mode) weight += part.weight();
    const std::vector<Eigen::Vector4d>& normals = Draws(mode.front().num_dimensions());
    int likelier = 0, drawn = 0;
    for (std::size_t pair = modes.size() / 2; 2 * pair < normals.size(); pair += modes.size()) {
      const ModeDensity& part = PartAt(mode, FractionOf(drawn * std::numbers::sqrt2));
      for (const std::size_t i : {2 * pair, 2 * pair + 1}) {
        const double turn = FractionOf(++drawn * std::numbers::phi);
        likelier += density_at(part.Draw(normals[i], turn)) > at_truth;
      }
    }
    level += weight * likelier / drawn;
  }
  return level;
}

}  // namespace

double CredibleLevel(std::span<const BeliefMode> modes, const TrueState& truth) {
  if (const std::optional<double> level = LevelOfOne(modes, truth)) return *level;
  return std::min(DrawnLevel(PartsOf(modes, truth), truth), 1.0);
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
