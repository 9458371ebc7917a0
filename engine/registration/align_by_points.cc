// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/registration/sequence_frames.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d Skew(const Vector3d& v) {
  Matrix3d skew;
  skew << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return skew;
}

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
    Isometry3d start = UprightPlace(gravity, 2 * std::numbers::pi * i / (5 * kAzimuths), {0, 0, 0});
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
  constexpr double kPatch_m = 0.3;  // What maps and scans err together over.
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
    start = UprightPlace(gravity, azimuth, Vector3d::Zero());
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
  const double effect = pose.DesignEffect(met.pairs, kPatch_m);
  const PoseCovariance covariance =
      pose.PlaneCovariance(met.pairs, std::sqrt(effect) * alignment.rmse_m);
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

}  // namespace plumbline
