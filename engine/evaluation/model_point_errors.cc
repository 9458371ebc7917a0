// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/model_point_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/base/check.h"
#include "engine/geometry/point_tree.h"

namespace plumbline {
namespace {

constexpr double kSymmetryStep = 0.01;  ///< Of the diameter.

/// What `distance` has at most over the points, for the best of the turns.
template <typename Distance>
double LargestOfBest(std::span<const Eigen::Isometry3d> turns, const ModelPoints& points,
                     const Distance& distance) {
  PLB_CHECK(!turns.empty() && !points.empty());
  double best = std::numeric_limits<double>::infinity();
  for (const Eigen::Isometry3d& turn : turns) {
    double largest = 0;
    for (std::size_t i = 0; i < points.size() && largest < best; ++i)
      largest = std::max(largest, distance(i, turn));
    best = std::min(best, largest);
  }
  return best;
}

bool IsVisible(float model, float scene) {
  return model > 0 && (scene == 0 || model - scene <= static_cast<float>(kVsdTolerance_m));
}

}  // namespace

ModelPoints PointsOf(const TriangleMesh& mesh) {
  ModelPoints points;
  for (const Eigen::Vector3f& vertex : mesh.vertices) points.push_back(vertex.cast<double>());
  return points;
}

std::vector<Eigen::Isometry3d> SymmetricTurns(const Symmetry& symmetry) {
  const int count = symmetry.order > 0
                        ? symmetry.order
                        : static_cast<int>(std::ceil(std::numbers::pi / kSymmetryStep));
  std::vector<Eigen::Isometry3d> turns;
  for (int i = 0; i < count; ++i) {
    turns.emplace_back(
        Eigen::AngleAxisd(2 * std::numbers::pi * i / count, symmetry.axis.normalized()));
  }
  return turns;
}

double AddError(const Eigen::Affine3d& estimate, const Eigen::Affine3d& truth,
                const ModelPoints& points) {
  PLB_CHECK(!points.empty());
  double sum = 0;
  for (const Eigen::Vector3d& point : points) sum += (estimate * point - truth * point).norm();
  return sum / static_cast<double>(points.size());
}

double AddSError(const Eigen::Affine3d& estimate, const Eigen::Affine3d& truth,
                 const ModelPoints& points) {
  PLB_CHECK(!points.empty());
  // In the frame of the estimate's origin: far from that of the world, floats are coarse.
  const Eigen::Vector3d origin = estimate.translation();
  std::vector<Eigen::Vector3f> estimated;
  for (const Eigen::Vector3d& point : points)
    estimated.push_back((estimate * point - origin).cast<float>());
  const PointTree tree(std::move(estimated));
  double sum = 0;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d place = truth * point - origin;
    const int nearest = tree.Nearest(place.cast<float>()).index;
    sum += (tree.points()[static_cast<std::size_t>(nearest)].cast<double>() - place).norm();
  }
  return sum / static_cast<double>(points.size());
}

double MssdError(const Eigen::Affine3d& estimate, const Eigen::Affine3d& truth,
                 const ModelPoints& points, std::span<const Eigen::Isometry3d> turns) {
  ModelPoints estimated;
  for (const Eigen::Vector3d& point : points) estimated.push_back(estimate * point);
  return LargestOfBest(turns, points, [&](std::size_t i, const Eigen::Isometry3d& turn) {
    return (estimated[i] - truth * (turn * points[i])).norm();
  });
}

double MspdError(const Eigen::Affine3d& estimate, const Eigen::Affine3d& truth,
                 const PinholeCamera& camera, const ModelPoints& points,
                 std::span<const Eigen::Isometry3d> turns) {
  std::vector<Eigen::Vector2d> estimated;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d in_cam = estimate * point;
    if (in_cam.z() <= 0) return std::numeric_limits<double>::infinity();
    estimated.push_back(camera.Project(in_cam));
  }
  return LargestOfBest(turns, points, [&](std::size_t i, const Eigen::Isometry3d& turn) {
    const Eigen::Vector3d in_cam = truth * (turn * points[i]);
    if (in_cam.z() <= 0) return std::numeric_limits<double>::infinity();
    return (estimated[i] - camera.Project(in_cam)).norm();
  });
}

cv::Mat RayLengths(const cv::Mat& depth, const PinholeCamera& camera) {
  PLB_CHECK(depth.type() == CV_32F);
  cv::Mat lengths(depth.size(), CV_32F);
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      const double slant = camera.Bearing({x, y}).homogeneous().norm();
      lengths.at<float>(y, x) = static_cast<float>(slant * depth.at<float>(y, x));
    }
  }
  return lengths;
}

std::vector<double> VsdErrors(const VsdImages& images, double diameter_m,
                              std::span<const double> taus) {
  PLB_CHECK(images.estimate.size() == images.truth.size() &&
            images.truth.size() == images.scene.size());
  std::vector<double> distances;  // where both show
  int either = 0;
  for (int y = 0; y < images.truth.rows; ++y) {
    const auto* estimate = images.estimate.ptr<float>(y);
    const auto* truth = images.truth.ptr<float>(y);
    const auto* scene = images.scene.ptr<float>(y);
    for (int x = 0; x < images.truth.cols; ++x) {
      const bool truth_shows = IsVisible(truth[x], scene[x]);
      const bool estimate_shows =
          IsVisible(estimate[x], scene[x]) || (truth_shows && estimate[x] > 0);
      either += truth_shows || estimate_shows;
      if (truth_shows && estimate_shows)
        distances.push_back(std::abs(truth[x] - estimate[x]) / diameter_m);
    }
  }
  std::vector<double> errors;
  for (const double tau : taus) {
    const auto right = std::count_if(distances.begin(), distances.end(),
                                     [&](double distance) { return distance < tau; });
    errors.push_back(either > 0 ? 1 - static_cast<double>(right) / either : 1.0);
  }
  return errors;
}

int VisiblePixels(const cv::Mat& truth, const cv::Mat& scene) {
  int count = 0;
  for (int y = 0; y < truth.rows; ++y) {
    for (int x = 0; x < truth.cols; ++x)
      count += IsVisible(truth.at<float>(y, x), scene.at<float>(y, x));
  }
  return count;
}

}  // namespace plumbline
