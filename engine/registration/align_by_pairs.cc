// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "engine/geometry/gravity.h"
#include "engine/geometry/symmetric_matrix.h"
#include "engine/registration/sequence_frames.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPointSigma_m = 0.02, kClickSigma_px = 2;
constexpr double kLeastDepth_m = 0.05;

class PairProblem {
 public:
  PairProblem(const std::vector<PickedPair>& pairs, const GravityPair& gravity)
      : pairs_(pairs), gravity_(gravity) {}

  struct Fit {
    Isometry3d scan_from_world = Isometry3d::Identity();
    double cost = std::numeric_limits<double>::infinity();
  };

  /// The best translation for an azimuth: linear once the depths along the rays are known.
  Fit FitAt(double azimuth_rad) const {
    Fit fit{UprightPlace(gravity_, azimuth_rad, Vector3d::Zero())};
    std::vector<double> depths(pairs_.size(), 3.0);
    for (int round = 0; round < 4; ++round) {
      Matrix3d normal = 1e-12 * Matrix3d::Identity();
      Vector3d right = Vector3d::Zero();
      for (std::size_t i = 0; i < pairs_.size(); ++i) {
        const auto [origin, across, weight] = Term(fit.scan_from_world.linear(), i, depths[i]);
        normal += weight * across;
        right += weight * across * (pairs_[i].in_scan - origin);
      }
      fit.scan_from_world.translation() = SolveSymmetric(normal, right);
      for (std::size_t i = 0; i < pairs_.size(); ++i) {
        depths[i] = std::max(std::abs(Depth(fit.scan_from_world, i)), kLeastDepth_m);
      }
    }
    fit.cost = Residuals(fit.scan_from_world).squaredNorm();
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (Depth(fit.scan_from_world, i) < kLeastDepth_m) {
        fit.cost = std::numeric_limits<double>::infinity();
      }
    }
    return fit;
  }

  /// Distances of the picked points from where the world has them, in standard deviations: three
  /// numbers for each pair, of which a ray shows two.
  Eigen::VectorXd Residuals(const Isometry3d& scan_from_world) const {
    Eigen::VectorXd residuals(3 * pairs_.size());
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const double depth = std::max(std::abs(Depth(scan_from_world, i)), kLeastDepth_m);
      const auto [origin, across, weight] = Term(scan_from_world.linear(), i, depth);
      residuals.segment<3>(3 * static_cast<Eigen::Index>(i)) =
          std::sqrt(weight) * across * (pairs_[i].in_scan - origin - scan_from_world.translation());
    }
    return residuals;
  }

  int num_equations() const {
    int count = 0;
    for (const PickedPair& pair : pairs_) {
      count += std::holds_alternative<WorldRay>(pair.in_world) ? 2 : 3;
    }
    return count;
  }

 private:
  struct Linear {
    Vector3d origin;  ///< Turned into the scan, not yet shifted.
    Matrix3d across;  ///< Takes away what the pair does not see.
    double weight;
  };

  Linear Term(const Matrix3d& turn, std::size_t i, double depth) const {
    if (const auto* ray = std::get_if<WorldRay>(&pairs_[i].in_world)) {
      const Vector3d direction = turn * ray->direction_in_world;
      const double sigma = kClickSigma_px * ray->pixel_rad * depth;
      return {turn * ray->origin_in_world, Matrix3d::Identity() - direction * direction.transpose(),
              1 / (sigma * sigma)};
    }
    return {turn * std::get<Vector3d>(pairs_[i].in_world), Matrix3d::Identity(),
            1 / (kPointSigma_m * kPointSigma_m)};
  }

  double Depth(const Isometry3d& scan_from_world, std::size_t i) const {
    const auto* ray = std::get_if<WorldRay>(&pairs_[i].in_world);
    if (ray == nullptr) return 1;
    return (scan_from_world.linear() * ray->direction_in_world)
        .dot(pairs_[i].in_scan - scan_from_world * ray->origin_in_world);
  }

  const std::vector<PickedPair>& pairs_;
  const GravityPair& gravity_;
};

/// The best azimuth: all around, then by thirds of an interval.
PairProblem::Fit BestAzimuth(const PairProblem& problem) {
  constexpr int kSteps = 180, kRounds = 60;
  constexpr double kStep_rad = 2 * std::numbers::pi / kSteps;
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kSteps; ++i) {
    const double cost = problem.FitAt(i * kStep_rad).cost;
    if (cost < least) {
      least = cost;
      best = i;
    }
  }
  double low = (best - 1) * kStep_rad, high = (best + 1) * kStep_rad;
  for (int i = 0; i < kRounds; ++i) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (problem.FitAt(a).cost < problem.FitAt(b).cost) {
      high = b;
    } else {
      low = a;
    }
  }
  return problem.FitAt(0.5 * (low + high));
}

/// By central differences about the middle of the points in the scan.
Eigen::Matrix4d InformationOf(const PairProblem& problem, const Isometry3d& pose,
                              const Vector3d& middle, const Vector3d& up) {
  Eigen::Matrix<double, Eigen::Dynamic, 4> jacobian(problem.Residuals(pose).size(), 4);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 4; ++k) {
    const auto moved = [&](double by) {
      Isometry3d step = Isometry3d::Identity();
      if (k < 3) {
        step.translation()[k] = by;
      } else {
        step = Eigen::Translation3d(middle) * Eigen::AngleAxisd(by, up) *
               Eigen::Translation3d(-middle);
      }
      return problem.Residuals(step * pose);
    };
    jacobian.col(k) = (moved(kStep) - moved(-kStep)) / (2 * kStep);
  }
  return jacobian.transpose() * jacobian;
}

}  // namespace

Result<SequenceAlignment> AlignByPairs(const std::vector<PickedPair>& pairs,
                                       const GravityPair& gravity) {
  if (const Status status = CheckGravity(gravity); !status.ok()) return status.error();
  if (pairs.size() < 2) {
    return Error{ErrorCode::kInvalidInput, "two pairs are needed at least; pick more"};
  }
  const Error unseen{ErrorCode::kDegenerate,
                     "these pairs do not show where the sequence is and how it is turned; pick "
                     "points that lie far apart, from different places"};
  const PairProblem problem(pairs, gravity);
  const PairProblem::Fit best = BestAzimuth(problem);
  if (!std::isfinite(best.cost)) return unseen;
  Vector3d middle = Vector3d::Zero();
  for (const PickedPair& pair : pairs) middle += pair.in_scan / static_cast<double>(pairs.size());
  const Eigen::Matrix4d information =
      InformationOf(problem, best.scan_from_world, middle, -gravity.in_scan);
  // A metre or a third of a turn that costs nothing.
  if (!(EigenOf(information).values[0] > 1)) return unseen;
  const int redundant = problem.num_equations() - 4;
  const double scale = redundant > 0 ? std::max(1.0, best.cost / redundant) : 1;
  const Eigen::Matrix4d covariance = scale * information.inverse();
  SequenceAlignment alignment;
  alignment.scan_from_world = best.scan_from_world;
  alignment.position_std_m = covariance.diagonal().head<3>().cwiseSqrt();
  alignment.azimuth_std_rad = std::sqrt(covariance(3, 3));
  const Eigen::VectorXd residuals = problem.Residuals(best.scan_from_world);
  double squares = 0;
  int points = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double sigmas = residuals.segment<3>(3 * static_cast<Eigen::Index>(i)).norm();
    const bool is_ray = std::holds_alternative<WorldRay>(pairs[i].in_world);
    alignment.residuals.push_back(sigmas * (is_ray ? kClickSigma_px : kPointSigma_m));
    if (is_ray) continue;
    squares += alignment.residuals.back() * alignment.residuals.back();
    ++points;
  }
  alignment.rmse_m = points > 0 ? std::sqrt(squares / points) : 0;
  return alignment;
}

}  // namespace plumbline
