// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/sequence_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPointSigma_m = 0.02, kClickSigma_px = 2;
constexpr double kLeastDepth_m = 0.05;

Status CheckGravity(const GravityPair& gravity) {
  for (const Vector3d& down : {gravity.in_world, gravity.in_scan}) {
    if (!(std::abs(down.norm() - 1) < 1e-6)) {
      return Error{ErrorCode::kInvalidInput, "gravity must be a unit vector in both frames"};
    }
  }
  return {};
}

/// The world upright in the scan, turned by nothing yet.
Matrix3d UprightTurn(const GravityPair& gravity) {
  return Eigen::Quaterniond::FromTwoVectors(gravity.in_world, gravity.in_scan).toRotationMatrix();
}

Matrix3d Skew(const Vector3d& v) {
  Matrix3d skew;
  skew << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return skew;
}

Isometry3d PoseAt(const GravityPair& gravity, double azimuth_rad, const Vector3d& translation) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(azimuth_rad, -gravity.in_scan) * UprightTurn(gravity);
  pose.translation() = translation;
  return pose;
}

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
    Fit fit{PoseAt(gravity_, azimuth_rad, Vector3d::Zero())};
    std::vector<double> depths(pairs_.size(), 3.0);
    for (int round = 0; round < 4; ++round) {
      Matrix3d normal = 1e-12 * Matrix3d::Identity();
      Vector3d right = Vector3d::Zero();
      for (std::size_t i = 0; i < pairs_.size(); ++i) {
        const auto [origin, across, weight] = Term(fit.scan_from_world.linear(), i, depths[i]);
        normal += weight * across;
        right += weight * across * (pairs_[i].in_scan - origin);
      }
      fit.scan_from_world.translation() = normal.ldlt().solve(right);
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
  Eigen::MatrixXd jacobian(problem.Residuals(pose).size(), 4);
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
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(information);
  // A metre or a third of a turn that costs nothing.
  if (!(solver.eigenvalues()[0] > 1)) return unseen;
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

namespace {

struct Met {
  std::vector<PointPair> pairs;
  double squares = 0;  ///< Of the distances along the normals.
};

/// Scan points within reach of the world's points; weights fall with the distance.
Met MeetScan(const std::vector<Eigen::Vector3f>& points, const ScanTarget& scan,
             const Isometry3d& pose, double reach_m) {
  Met met;
  for (const Eigen::Vector3f& point : points) {
    const Vector3d in_scan = pose * point.cast<double>();
    const auto nearest = scan.tree().Nearest(in_scan.cast<float>());
    if (nearest.index < 0 || nearest.squared_distance > reach_m * reach_m) continue;
    const auto index = static_cast<std::size_t>(nearest.index);
    PointPair pair;
    pair.in_model = point.cast<double>();
    pair.in_scan = scan.points().points[index].cast<double>();
    pair.normal_in_scan = scan.points().normals[index].cast<double>();
    const double share = nearest.squared_distance / (reach_m * reach_m);
    pair.weight = (1 - share) * (1 - share);
    const double off = pair.normal_in_scan.dot(in_scan - pair.in_scan);
    met.squares += off * off;
    met.pairs.push_back(pair);
  }
  return met;
}

std::vector<Eigen::Vector3f> Thinned(const std::vector<Eigen::Vector3f>& points,
                                     std::size_t count) {
  std::vector<Eigen::Vector3f> thinned;
  const std::size_t stride = std::max<std::size_t>(1, points.size() / count);
  for (std::size_t i = 0; i < points.size(); i += stride) thinned.push_back(points[i]);
  return thinned;
}

/// The mean of those that are not far away; turned points have a turned middle.
Vector3d MiddleOf(const std::vector<Eigen::Vector3f>& points) {
  Vector3d middle = Vector3d::Zero();
  double within = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 3; ++round) {
    Vector3d sum = Vector3d::Zero();
    double squares = 0, count = 0;
    for (const Eigen::Vector3f& point : points) {
      const double distance2 = (point.cast<double>() - middle).squaredNorm();
      if (round > 0 && distance2 > within) continue;
      sum += point.cast<double>();
      squares += distance2;
      ++count;
    }
    if (round > 0) within = 4 * squares / count;
    middle = sum / count;
  }
  return middle;
}

/// With a reach that shrinks; the number of steps.
int Settle(const std::vector<Eigen::Vector3f>& points, const ScanTarget& scan, double reach_m,
           double least_reach_m, ConstrainedPose& pose) {
  constexpr double kStill = 1e-6;
  int iterations = 0;
  for (; reach_m >= least_reach_m; reach_m *= 0.7) {
    for (int i = 0; i < 8; ++i, ++iterations) {
      const Met met = MeetScan(points, scan, pose.scan_from_model(), reach_m);
      if (met.pairs.size() < 10 || pose.StepPlanes(met.pairs) < kStill) break;
    }
  }
  return iterations;
}

/// The place from which most points meet the scan: all azimuths, about the middles and beside them.
Isometry3d RoughPlace(const std::vector<Eigen::Vector3f>& points, const ScanTarget& scan,
                      const GravityPair& gravity, const WorkContext& work) {
  constexpr int kAzimuths = 36;
  constexpr double kBeside_m = 0.8;
  const Vector3d in_world = MiddleOf(points), in_scan = MiddleOf(scan.points().points);
  const Vector3d ahead = gravity.in_scan.unitOrthogonal(), aside = ahead.cross(gravity.in_scan);
  const Vector3d shifts[] = {Vector3d::Zero(), ahead, -ahead, aside, -aside};
  const auto few = Thinned(points, 250);
  Isometry3d best = Isometry3d::Identity();
  double most = -1;
  for (int i = 0; i < kAzimuths * 5 && !work.stop.stop_requested(); ++i) {
    Isometry3d start = PoseAt(gravity, 2 * std::numbers::pi * i / (5 * kAzimuths), {0, 0, 0});
    start.translation() = in_scan + kBeside_m * shifts[i % 5] - start.linear() * in_world;
    ConstrainedPose pose(start, -gravity.in_scan, FreeMotion::kAzimuthAndTranslation);
    Settle(few, scan, 1.0, 0.08, pose);
    double met = 0;
    for (const PointPair& pair : MeetScan(few, scan, pose.scan_from_model(), 0.06).pairs) {
      met += pair.weight;
    }
    if (met <= most) continue;
    most = met;
    best = pose.scan_from_model();
  }
  return best;
}

}  // namespace

Result<SequenceAlignment> AlignByPoints(const std::vector<Eigen::Vector3f>& points_in_world,
                                        const ScanTarget& scan, const GravityPair& gravity,
                                        const std::optional<Isometry3d>& scan_from_world,
                                        const WorkContext& work) {
  constexpr double kReach_m = 0.5, kLeastReach_m = 0.05;
  if (const Status status = CheckGravity(gravity); !status.ok()) return status.error();
  if (points_in_world.size() < 30) {
    return Error{ErrorCode::kInvalidInput, "the sequence's map has fewer than 30 points"};
  }
  const auto points = Thinned(points_in_world, 6000);
  Isometry3d start;
  if (scan_from_world) {  // upright, with the turn and the middle that it has
    const Vector3d middle = MiddleOf(points);
    const Matrix3d turn = scan_from_world->linear() * UprightTurn(gravity).transpose();
    const Vector3d up = -gravity.in_scan;
    const Vector3d axis = up.unitOrthogonal(), turned = turn * axis;
    const double azimuth = std::atan2(up.dot(axis.cross(turned)), axis.dot(turned));
    start = PoseAt(gravity, azimuth, Vector3d::Zero());
    start.translation() = *scan_from_world * middle - start.linear() * middle;
  } else {
    start = RoughPlace(points, scan, gravity, work);
  }
  if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "cancelled"};
  ConstrainedPose pose(start, -gravity.in_scan, FreeMotion::kAzimuthAndTranslation);
  SequenceAlignment alignment;
  alignment.iterations = Settle(points, scan, kReach_m, kLeastReach_m, pose);
  const Met met = MeetScan(points, scan, pose.scan_from_model(), kLeastReach_m);
  if (met.pairs.size() < std::max<std::size_t>(30, points.size() / 20)) {
    return Error{ErrorCode::kDegenerate,
                 "the points of the sequence's map do not meet the scan; place it roughly by pairs "
                 "first"};
  }
  alignment.scan_from_world = pose.scan_from_model();
  alignment.share = static_cast<double>(met.pairs.size()) / static_cast<double>(points.size());
  alignment.rmse_m = std::sqrt(met.squares / static_cast<double>(met.pairs.size()));
  const PoseCovariance covariance = pose.PlaneCovariance(met.pairs, alignment.rmse_m);
  const Vector3d up = -gravity.in_scan;
  // At the middle of the points: at the world's origin the turn would count twice.
  const Vector3d lever = alignment.scan_from_world.linear() * MiddleOf(points);
  Eigen::Matrix<double, 3, 6> at_middle;
  at_middle << Matrix3d::Identity(), -Skew(lever);
  alignment.position_std_m =
      (at_middle * covariance * at_middle.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
  alignment.azimuth_std_rad =
      std::sqrt(std::max(0.0, up.dot(covariance.bottomRightCorner<3, 3>() * up)));
  return alignment;
}

namespace {

constexpr double kPartners_m = 0.5;

/// Which annotated object each mapped one meets, nearest first, each once; -1: none.
std::vector<int> Partners(const std::vector<PosedObject>& mapped,
                          const std::vector<PosedObject>& annotated, const Isometry3d& pose) {
  struct Offer {
    double distance;
    std::size_t mapped, annotated;
  };
  std::vector<Offer> offers;
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    for (std::size_t j = 0; j < annotated.size(); ++j) {
      if (mapped[i].kind != annotated[j].kind) continue;
      const double distance =
          (pose * mapped[i].pose.translation() - annotated[j].pose.translation()).norm();
      if (distance < kPartners_m) offers.push_back({distance, i, j});
    }
  }
  std::stable_sort(offers.begin(), offers.end(),
                   [](const Offer& a, const Offer& b) { return a.distance < b.distance; });
  std::vector<int> partners(mapped.size(), -1);
  std::vector<char> taken(annotated.size(), 0);
  for (const Offer& offer : offers) {
    if (partners[offer.mapped] >= 0 || taken[offer.annotated]) continue;
    partners[offer.mapped] = static_cast<int>(offer.annotated);
    taken[offer.annotated] = 1;
  }
  return partners;
}

std::vector<PointPair> PairsOf(const std::vector<PosedObject>& mapped,
                               const std::vector<PosedObject>& annotated,
                               const std::vector<int>& partners) {
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    if (partners[i] < 0) continue;
    PointPair pair;
    pair.in_model = mapped[i].pose.translation();
    pair.in_scan = annotated[static_cast<std::size_t>(partners[i])].pose.translation();
    pairs.push_back(pair);
  }
  return pairs;
}

/// Every place at which one object lies on one of its kind the way that it is turned, or two lie on
/// two: the latter needs no turn, which symmetric objects do not have.
std::vector<Isometry3d> PlacesOf(const std::vector<PosedObject>& mapped,
                                 const std::vector<PosedObject>& annotated,
                                 const GravityPair& gravity) {
  std::vector<Isometry3d> places;
  const UprightFrame upright(gravity.in_scan);
  std::vector<PointPair> single;
  for (const PosedObject& a : mapped) {
    for (const PosedObject& b : annotated) {
      if (a.kind != b.kind) continue;
      PointPair pair;
      pair.in_model = a.pose.translation();
      pair.in_scan = b.pose.translation();
      single.push_back(pair);
      Isometry3d place = PoseAt(gravity, 0, Vector3d::Zero());
      place = PoseAt(
          gravity,
          upright.Azimuth(b.pose.linear()) - upright.Azimuth(place.linear() * a.pose.linear()),
          Vector3d::Zero());
      place.translation() = pair.in_scan - place.linear() * pair.in_model;
      places.push_back(place);
    }
  }
  for (std::size_t i = 0; i < single.size(); ++i) {
    for (std::size_t j = i + 1; j < single.size(); ++j) {
      const double apart = (single[i].in_model - single[j].in_model).norm();
      const double apart_in_scan = (single[i].in_scan - single[j].in_scan).norm();
      if (apart < kPartners_m || std::abs(apart - apart_in_scan) > kPartners_m) continue;
      ConstrainedPose pose(PoseAt(gravity, 0, Vector3d::Zero()), -gravity.in_scan,
                           FreeMotion::kAzimuthAndTranslation);
      const PointPair two[] = {single[i], single[j]};
      if (pose.FitPoints(two).ok()) places.push_back(pose.scan_from_model());
    }
  }
  return places;
}

double Squares(const std::vector<PointPair>& pairs, const Isometry3d& pose) {
  double squares = 0;
  for (const PointPair& pair : pairs)
    squares += (pose * pair.in_model - pair.in_scan).squaredNorm();
  return squares;
}

/// Of the middle, if the distances are independent.
void SetDeviations(const std::vector<PointPair>& pairs, const GravityPair& gravity,
                   SequenceAlignment& alignment) {
  const auto count = static_cast<double>(pairs.size());
  Vector3d middle = Vector3d::Zero();
  for (const PointPair& pair : pairs) middle += pair.in_scan / count;
  double spread = 0;
  for (const PointPair& pair : pairs) {
    spread += (pair.in_scan - middle).cross(gravity.in_scan).squaredNorm();
  }
  const double equations = std::max(1.0, 3 * count - 4);
  const double sigma =
      std::max(kPointSigma_m, std::sqrt(Squares(pairs, alignment.scan_from_world) / equations));
  alignment.position_std_m.setConstant(sigma / std::sqrt(count));
  alignment.azimuth_std_rad = sigma / std::sqrt(std::max(spread, 1e-6));
}

}  // namespace

Result<SequenceAlignment> AlignByObjects(const std::vector<PosedObject>& mapped_in_world,
                                         const std::vector<PosedObject>& annotated_in_scan,
                                         const GravityPair& gravity) {
  if (const Status status = CheckGravity(gravity); !status.ok()) return status.error();
  Isometry3d best = Isometry3d::Identity();
  std::size_t most = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const Isometry3d& place : PlacesOf(mapped_in_world, annotated_in_scan, gravity)) {
    const auto pairs = PairsOf(mapped_in_world, annotated_in_scan,
                               Partners(mapped_in_world, annotated_in_scan, place));
    const double squares = Squares(pairs, place);
    if (pairs.size() < most || (pairs.size() == most && squares >= least)) continue;
    most = pairs.size();
    least = squares;
    best = place;
  }
  if (most < 2) {
    return Error{ErrorCode::kDegenerate,
                 "fewer than two mapped objects meet annotated ones of their kind; annotate more "
                 "of them, or pick pairs"};
  }
  ConstrainedPose pose(best, -gravity.in_scan, FreeMotion::kAzimuthAndTranslation);
  std::vector<int> partners;
  for (int i = 0; i < 5; ++i) {
    partners = Partners(mapped_in_world, annotated_in_scan, pose.scan_from_model());
    const auto pairs = PairsOf(mapped_in_world, annotated_in_scan, partners);
    if (const Status fitted = pose.FitPoints(pairs); !fitted.ok()) break;  // above one another
  }
  SequenceAlignment alignment;
  alignment.scan_from_world = pose.scan_from_model();
  const auto pairs = PairsOf(mapped_in_world, annotated_in_scan, partners);
  SetDeviations(pairs, gravity, alignment);
  const auto count = static_cast<double>(pairs.size());
  alignment.share = count / static_cast<double>(mapped_in_world.size());
  alignment.rmse_m = std::sqrt(Squares(pairs, alignment.scan_from_world) / count);
  for (std::size_t i = 0; i < mapped_in_world.size(); ++i) {
    alignment.residuals.push_back(-1);
    if (partners[i] < 0) continue;
    const auto j = static_cast<std::size_t>(partners[i]);
    alignment.residuals.back() =
        (alignment.scan_from_world * mapped_in_world[i].pose.translation() -
         annotated_in_scan[j].pose.translation())
            .norm();
  }
  return alignment;
}

}  // namespace plumbline
