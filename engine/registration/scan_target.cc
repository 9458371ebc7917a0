// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/scan_target.h"

#include <cmath>
#include <cstdint>
#include <unordered_set>
#include <utility>

#include <tbb/parallel_for.h>
#include <Eigen/Eigenvalues>

namespace plumbline {
namespace {

constexpr std::size_t kFewestScanPoints = 10;
constexpr int kNormalNeighbors = 16;

std::vector<Eigen::Vector3f> NormalsOfNeighborhoods(const PointTree& tree) {
  const std::vector<Eigen::Vector3f>& points = tree.points();
  std::vector<Eigen::Vector3f> normals(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const auto neighbors = tree.Nearest(points[i], kNormalNeighbors);
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();
    for (const auto& n : neighbors) mean += points[static_cast<std::size_t>(n.index)];
    mean /= static_cast<float>(neighbors.size());
    Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
    for (const auto& n : neighbors) {
      const Eigen::Vector3f d = points[static_cast<std::size_t>(n.index)] - mean;
      spread += d * d.transpose();
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen;
    eigen.computeDirect(spread);
    normals[i] = eigen.eigenvectors().col(0);
  });
  return normals;
}

void FaceCameras(const std::vector<Eigen::Vector3d>& camera_centers, OrientedPoints& points) {
  std::vector<Eigen::Vector3f> centers;
  for (const Eigen::Vector3d& center : camera_centers) centers.push_back(center.cast<float>());
  const PointTree tree(centers);
  tbb::parallel_for(std::size_t{0}, points.points.size(), [&](std::size_t i) {
    const auto nearest = static_cast<std::size_t>(tree.Nearest(points.points[i]).index);
    if (points.normals[i].dot(centers[nearest] - points.points[i]) < 0) {
      points.normals[i] = -points.normals[i];
    }
  });
}

std::uint64_t VoxelKey(const Eigen::Vector3f& point, float voxel_m) {
  const auto part = [&](float x) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / voxel_m))) &
           0x1fffff;
  };
  return part(point.x()) | part(point.y()) << 21 | part(point.z()) << 42;
}

}  // namespace

Result<std::shared_ptr<const ScanTarget>> ScanTarget::Prepare(
    const TriangleMesh& scan, const std::vector<Eigen::Vector3d>& camera_centers) {
  if (scan.vertices.size() < kFewestScanPoints) {
    return Error{ErrorCode::kDegenerate, "the scan has " + std::to_string(scan.vertices.size()) +
                                             " points; nothing can be aligned to so few"};
  }
  PointTree tree(scan.vertices);
  OrientedPoints points;
  points.points = scan.vertices;
  bool face_out = true;
  if (!scan.normals.empty()) {
    points.normals = scan.normals;
  } else if (!scan.triangles.empty()) {
    TriangleMesh shaded;
    shaded.vertices = scan.vertices;
    shaded.triangles = scan.triangles;
    ComputeNormals(shaded);
    points.normals = std::move(shaded.normals);
  } else {
    points.normals = NormalsOfNeighborhoods(tree);
    face_out = !camera_centers.empty();
    if (face_out) FaceCameras(camera_centers, points);
  }
  for (Eigen::Vector3f& normal : points.normals) {
    const float length = normal.norm();
    normal = length > 0.5f ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::Zero();
  }
  return std::shared_ptr<const ScanTarget>(
      new ScanTarget(std::move(points), std::move(tree), face_out));
}

std::vector<int> VoxelSample(const std::vector<Eigen::Vector3f>& points, float voxel_m,
                             std::size_t max_count) {
  std::unordered_set<std::uint64_t> seen;
  seen.reserve(points.size() / 2);
  std::vector<int> chosen;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (seen.insert(VoxelKey(points[i], voxel_m)).second) chosen.push_back(static_cast<int>(i));
  }
  if (chosen.size() <= max_count) return chosen;
  std::vector<int> fewer(max_count);
  for (std::size_t i = 0; i < max_count; ++i) fewer[i] = chosen[i * chosen.size() / max_count];
  return fewer;
}

OrientedPoints Select(const OrientedPoints& points, const std::vector<int>& indices) {
  OrientedPoints selected;
  selected.points.reserve(indices.size());
  selected.normals.reserve(indices.size());
  for (const int i : indices) {
    selected.points.push_back(points.points[static_cast<std::size_t>(i)]);
    selected.normals.push_back(points.normals[static_cast<std::size_t>(i)]);
  }
  return selected;
}

}  // namespace plumbline
