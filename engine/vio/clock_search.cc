// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/clock_search.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <vector>

#include <Eigen/Eigenvalues>

#include "engine/base/check.h"
#include "engine/sensor/distorted_camera.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

constexpr std::int64_t kPairNs = 300'000'000;  ///< At least, between the images of a pair.
constexpr std::size_t kMinCommon = 12;
constexpr std::size_t kMinPairs = 3;
constexpr double kCoarse = 0.01, kFine = 0.001;  ///< Steps of the search [s].
constexpr double kTrusted = 0.8;                 ///< Share of a pair's points that count.

/// Two images with their common points' rays, in the body's axes.
struct Pair {
  std::int64_t first_ns, second_ns;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> rays;
};

std::vector<Pair> PairsOf(const Camera& camera, std::span<const TrackedImage> images) {
  const DistortedCamera lens(camera);
  const Eigen::Matrix3d body_from_cam = camera.body_from_cam->linear();
  std::vector<std::unordered_map<std::int64_t, Eigen::Vector3d>> rays(images.size());
  for (std::size_t k = 0; k < images.size(); ++k) {
    for (const TrackedPoint& point : images[k].points) {
      if (const auto ray = lens.Unproject(point.pixel)) rays[k][point.id] = body_from_cam * *ray;
    }
  }
  std::vector<Pair> pairs;
  for (std::size_t first = 0; first < images.size(); ++first) {
    std::size_t second = first + 1;
    while (second < images.size() && images[second].stamp_ns < images[first].stamp_ns + kPairNs)
      ++second;
    if (second == images.size()) break;
    Pair pair{images[first].stamp_ns, images[second].stamp_ns, {}};
    for (const auto& [id, ray] : rays[first]) {
      const auto found = rays[second].find(id);
      if (found != rays[second].end()) pair.rays.emplace_back(ray, found->second);
    }
    if (pair.rays.size() >= kMinCommon) pairs.push_back(std::move(pair));
  }
  return pairs;
}

/// Sum over a pair's points of the squared sine off the best epipolar planes.
double Misfit(const Pair& pair, const Eigen::Matrix3d& first_from_second) {
  std::vector<Eigen::Vector3d> normals;
  for (const auto& [first, second] : pair.rays)
    normals.push_back(first.cross(first_from_second * second));
  std::vector<double> off;
  // Once with all points, once without the worst: mismatches.
  for (int round = 0; round < 2; ++round) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& normal : normals) sum += normal * normal.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum);
    const Eigen::Vector3d direction = solver.eigenvectors().col(0);
    if (round == 1) return std::max(solver.eigenvalues()(0), 0.0);
    const auto kept = static_cast<std::ptrdiff_t>(kTrusted * static_cast<double>(normals.size()));
    std::nth_element(normals.begin(), normals.begin() + kept, normals.end(),
                     [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
                       return std::abs(a.dot(direction)) < std::abs(b.dot(direction));
                     });
    normals.resize(static_cast<std::size_t>(kept));
  }
  return 0;
}

}  // namespace

std::optional<ClockFit> SearchClock(const Camera& camera, const ImuBuffer& readings,
                                    const Eigen::Vector3d& gyro_bias,
                                    std::span<const TrackedImage> images, double given_s,
                                    double reach_s) {
  PLB_CHECK(camera.body_from_cam.has_value());
  if (readings.empty() || images.empty()) return std::nullopt;
  const std::vector<Pair> pairs = PairsOf(camera, images);
  if (pairs.size() < kMinPairs) return std::nullopt;
  double points = 0;
  for (const Pair& pair : pairs) points += kTrusted * static_cast<double>(pair.rays.size());
  const auto residual_px = [&](double offset_s) -> std::optional<double> {
    const std::int64_t offset = Nanoseconds(offset_s);
    if (readings.samples().front().stamp_ns > pairs.front().first_ns + offset ||
        !readings.Covers(pairs.back().second_ns + offset))
      return std::nullopt;
    double sum = 0;
    for (const Pair& pair : pairs) {
      Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
      for (const ImuSegment& s : readings.Between(pair.first_ns + offset, pair.second_ns + offset))
        turn = turn * RotationExp(s.seconds() * (s.angular_velocity_rad_s - gyro_bias));
      sum += Misfit(pair, turn);
    }
    return camera.pinhole.fx * std::sqrt(sum / points);
  };
  const std::optional<double> given = residual_px(given_s);
  if (!given) return std::nullopt;
  ClockFit best{given_s, *given, *given};
  const auto scan = [&](double middle, double reach, double step) {
    for (int k = -static_cast<int>(std::lround(reach / step)); k * step <= reach; ++k) {
      const std::optional<double> residual = residual_px(middle + k * step);
      if (residual && *residual < best.residual_px) {
        best.offset_s = middle + k * step;
        best.residual_px = *residual;
      }
    }
  };
  scan(given_s, reach_s, kCoarse);
  scan(best.offset_s, kCoarse, kFine);
  return best;
}

}  // namespace plumbline
