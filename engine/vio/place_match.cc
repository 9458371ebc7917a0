// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/place_match.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Cholesky>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "engine/geometry/angles.h"
#include "engine/vio/point_view.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

constexpr int kMaxDistance = 64;       ///< Of 256 bits.
constexpr double kClearlyBest = 0.85;  ///< Against the next best corner elsewhere.
constexpr double kElsewherePx = 6;     ///< Corners nearer than this are one, at several sizes.
constexpr int kRansacIterations = 300;
constexpr double kRansacConfidence = 0.995;
constexpr double kMatchNoisePx = 1.5;  ///< Of a corner that is found again.
constexpr double kHuberSigmas = 2;
constexpr int kIterations = 8;
/// Standard deviation of the inliers over the image, across their narrower direction, at a focal
/// length of one: fewer degrees hold no pose.
constexpr double kMinSpread = 0.05;
/// Rays farther off the axis of a very wide lens have no bearing [cosine].
constexpr double kMinRayZ = 0.2;

/// The best and the next best corner of each point.
struct BestCorners {
  int corner = -1, distance = 257, next = 257;
};

void Consider(int corner, int distance, const std::vector<PlaceCorner>& corners,
              BestCorners& best) {
  if (best.corner < 0) {
    best.corner = corner;
    best.distance = distance;
    return;
  }
  const auto pixel = [&](int index) { return corners[static_cast<std::size_t>(index)].pixel; };
  const bool same = (pixel(corner) - pixel(best.corner)).norm() < kElsewherePx;
  if (distance < best.distance) {
    if (!same) best.next = best.distance;
    best.corner = corner;
    best.distance = distance;
  } else if (!same) {
    best.next = std::min(best.next, distance);
  }
}

struct Refined {
  Eigen::Isometry3d world_from_body;
  double yaw_rad = 0;
  Eigen::Matrix4d information;  ///< Order (x, y, z, yaw).
  std::vector<PointMatch> inliers;
};

/// How the pixel of a match errs, in standard deviations, at a pose.
struct MatchError {
  Eigen::Vector2d error;
  Eigen::Matrix<double, 2, 4> by_pose;  ///< (x, y, z, yaw)
  double error_px = 0;
};

std::optional<MatchError> ErrorOf(const DistortedCamera& camera, const PlaceFrame& older,
                                  const PlaceFrame& seen, const PointMatch& match,
                                  const Eigen::Isometry3d& world_from_body) {
  const Eigen::Vector3d point_in_world =
      older.world_from_body * older.points_in_body[static_cast<std::size_t>(match.point)];
  const auto view = ViewPoint(camera, seen.body_from_cam, world_from_body, point_in_world);
  if (!view) return std::nullopt;
  const PlaceCorner& corner = seen.corners[static_cast<std::size_t>(match.corner)];
  MatchError result;
  const Eigen::Vector2d off = corner.pixel - view->pixel;
  const double noise = kMatchNoisePx * corner.size;
  result.error = off / noise;
  result.error_px = off.norm() / corner.size;
  // (phi, xi_p) of a turn about up that leaves the body in its place: xi_p = -z x p.
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const auto by_turn = view->by_pose.leftCols<3>(), by_move = view->by_pose.rightCols<3>();
  result.by_pose << by_move,
      by_turn * up - by_move * up.cross(Eigen::Vector3d(world_from_body.translation()));
  result.by_pose /= noise;
  return result;
}

/// Yaw and position by Gauss-Newton over the inliers; then those of `all` that lie close enough.
Refined Refine(const DistortedCamera& camera, const PlaceFrame& older, const PlaceFrame& seen,
               Refined place, const std::vector<PointMatch>& all, double match_px) {
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    place.information.setZero();
    Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
    for (const PointMatch& match : place.inliers) {
      const auto error = ErrorOf(camera, older, seen, match, place.world_from_body);
      if (!error) continue;
      const double size = error->error.norm();
      const double weight = size > kHuberSigmas ? kHuberSigmas / size : 1;
      place.information += weight * error->by_pose.transpose() * error->by_pose;
      gradient += weight * error->by_pose.transpose() * error->error;
    }
    const Eigen::Vector4d step = place.information.ldlt().solve(gradient);
    if (!step.allFinite()) break;
    place.world_from_body.linear() = RotationExp({0, 0, step(3)}) * place.world_from_body.linear();
    place.world_from_body.translation() += step.head<3>();
    place.yaw_rad += step(3);
    if (step.norm() < 1e-8) break;
  }
  place.inliers.clear();
  for (const PointMatch& match : all) {
    const auto error = ErrorOf(camera, older, seen, match, place.world_from_body);
    if (error && error->error_px < match_px) place.inliers.push_back(match);
  }
  return place;
}

/// A first pose, with the filter's roll and pitch, and the matches that agree on it.
std::optional<Refined> PlaceByRansac(double focal_px, const PlaceFrame& older,
                                     const PlaceFrame& seen, const std::vector<PointMatch>& matches,
                                     const LoopOptions& options) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> bearings;
  std::vector<PointMatch> usable;
  for (const PointMatch& match : matches) {
    const Eigen::Vector3d& ray = seen.corners[static_cast<std::size_t>(match.corner)].ray_in_cam;
    if (ray.z() < kMinRayZ) continue;
    const Eigen::Vector3d& p = older.points_in_body[static_cast<std::size_t>(match.point)];
    points.emplace_back(p.x(), p.y(), p.z());
    bearings.emplace_back(ray.x() / ray.z(), ray.y() / ray.z());
    usable.push_back(match);
  }
  const std::size_t enough = static_cast<std::size_t>(std::max(options.loop_min_inliers, 5));
  if (usable.size() < enough) return std::nullopt;
  cv::Mat turn, move, rotation;
  std::vector<int> agreeing;
  const double reach =
      1.5 * options.loop_match_px / focal_px;  // corners of upper levels are coarser
  if (!cv::solvePnPRansac(points, bearings, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turn, move,
                          false, kRansacIterations, static_cast<float>(reach), kRansacConfidence,
                          agreeing, cv::SOLVEPNP_EPNP) ||
      agreeing.size() < enough)
    return std::nullopt;
  cv::Rodrigues(turn, rotation);
  Eigen::Isometry3d cam_from_old = Eigen::Isometry3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) cam_from_old.linear()(r, c) = rotation.at<double>(r, c);
    cam_from_old.translation()[r] = move.at<double>(r);
  }
  const Eigen::Isometry3d world_from_body =
      older.world_from_body * (seen.body_from_cam * cam_from_old).inverse();
  // Up in the body is the third row of world_from_body: by the filter, and by the points.
  const Eigen::Vector3d by_filter = seen.world_from_body.linear().row(2).transpose();
  const Eigen::Vector3d by_points = world_from_body.linear().row(2).transpose();
  const double tilt = std::acos(std::clamp(by_filter.dot(by_points), -1.0, 1.0));
  if (tilt * kDegPerRad > options.loop_max_tilt_deg) return std::nullopt;

  const Eigen::Matrix3d off = world_from_body.linear() * seen.world_from_body.linear().transpose();
  Refined place;
  place.yaw_rad = std::atan2(off(1, 0) - off(0, 1), off(0, 0) + off(1, 1));
  place.world_from_body = seen.world_from_body;
  place.world_from_body.linear() =
      RotationExp({0, 0, place.yaw_rad}) * seen.world_from_body.linear();
  place.world_from_body.translation() = world_from_body.translation();
  for (const int index : agreeing) place.inliers.push_back(usable[static_cast<std::size_t>(index)]);
  return place;
}

bool SpreadEnough(const PlaceFrame& seen, const std::vector<PointMatch>& matches) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  for (const PointMatch& match : matches) {
    const Eigen::Vector3d& ray = seen.corners[static_cast<std::size_t>(match.corner)].ray_in_cam;
    mean += ray.head<2>();
    square += ray.head<2>() * ray.head<2>().transpose();
  }
  const double n = static_cast<double>(matches.size());
  const Eigen::Matrix2d spread = square / n - mean * mean.transpose() / (n * n);
  const double half = spread.trace() / 2;
  const double least = half - std::sqrt(std::max(0.0, half * half - spread.determinant()));
  return least > kMinSpread * kMinSpread;
}

}  // namespace

std::vector<PointMatch> MatchPoints(const PlaceFrame& older, const PlaceFrame& seen) {
  std::vector<PointMatch> matches;
  if (older.point_descriptors.empty() || seen.descriptors.empty()) return matches;
  cv::Mat distances;
  cv::batchDistance(older.point_descriptors, seen.descriptors, distances, CV_32S, cv::noArray(),
                    cv::NORM_HAMMING);
  std::vector<BestCorners> best(older.points_in_body.size());
  for (int row = 0; row < distances.rows; ++row) {
    BestCorners& of_point =
        best[static_cast<std::size_t>(older.point_of_row[static_cast<std::size_t>(row)])];
    for (int corner = 0; corner < distances.cols; ++corner)
      Consider(corner, distances.at<int>(row, corner), seen.corners, of_point);
  }
  std::map<int, std::pair<int, int>> of_corner;  // its nearest point: distance, point
  for (std::size_t point = 0; point < best.size(); ++point) {
    const BestCorners& b = best[point];
    if (b.corner < 0 || b.distance > kMaxDistance || b.distance > kClearlyBest * b.next) continue;
    const std::pair<int, int> offer(b.distance, static_cast<int>(point));
    const auto [place, fresh] = of_corner.emplace(b.corner, offer);
    if (!fresh) place->second = std::min(place->second, offer);
  }
  for (const auto& [corner, point] : of_corner) matches.push_back({point.second, corner});
  return matches;
}

std::optional<PlaceMatch> LocateByPoints(const DistortedCamera& camera, double focal_px,
                                         const PlaceFrame& older, const PlaceFrame& seen,
                                         const std::vector<PointMatch>& matches,
                                         const LoopOptions& options) {
  auto place = PlaceByRansac(focal_px, older, seen, matches, options);
  if (!place) return std::nullopt;
  for (int round = 0; round < 3; ++round) {
    if (static_cast<int>(place->inliers.size()) < options.loop_min_inliers) return std::nullopt;
    place = Refine(camera, older, seen, *place, matches, options.loop_match_px);
  }
  if (static_cast<int>(place->inliers.size()) < options.loop_min_inliers ||
      !SpreadEnough(seen, place->inliers))
    return std::nullopt;
  PlaceMatch match;
  match.yaw_rad = place->yaw_rad;
  match.position_in_world = place->world_from_body.translation();
  match.covariance = place->information.inverse();
  match.inliers = static_cast<int>(place->inliers.size());
  return match;
}

}  // namespace plumbline
