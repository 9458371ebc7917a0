// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/surface_sampling.h"

#include <cmath>

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "engine/base/random.h"

namespace plumbline {
namespace {

/// Triangles of many sizes, one of them without area.
TriangleMesh Fan() {
  TriangleMesh mesh;
  Random random({.seed = 4});
  for (int i = 0; i < 20; ++i) {
    const float size = static_cast<float>(0.1 + i);
    for (int corner = 0; corner < 3; ++corner) {
      mesh.vertices.emplace_back(size * static_cast<float>(random.Gaussian()),
                                 size * static_cast<float>(random.Gaussian()),
                                 size * static_cast<float>(random.Gaussian()));
    }
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  mesh.triangles[7] = {0, 0, 1};
  return mesh;
}

double Area(const TriangleMesh& mesh, std::size_t i) {
  TriangleMesh one;
  one.vertices = mesh.vertices;
  one.triangles = {mesh.triangles[i]};
  return SurfaceArea(one);
}

TEST(SampleSurface, EveryPointLiesInsideItsTriangle) {
  const TriangleMesh mesh = Fan();
  const SurfaceSamples samples = *SampleSurface(mesh, 20000, 1);
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(samples.triangles[i])];
    const auto corner = [&](int k) {
      return Eigen::Vector3d(mesh.vertices[static_cast<std::size_t>(t[k])].cast<double>());
    };
    const Eigen::Vector3d ab = corner(1) - corner(0), ac = corner(2) - corner(0);
    Eigen::Matrix3d basis;
    basis << ab, ac, ab.cross(ac).normalized();
    const Eigen::Vector3d coordinates = basis.inverse() * (samples.points[i] - corner(0));
    EXPECT_GE(coordinates.x(), -1e-12);
    EXPECT_GE(coordinates.y(), -1e-12);
    EXPECT_LE(coordinates.x() + coordinates.y(), 1 + 1e-12);
    EXPECT_NEAR(coordinates.z(), 0, 1e-9);
  }
}

TEST(SampleSurface, ReachesEveryFaceInProportionToItsArea) {
  const TriangleMesh mesh = Fan();
  const int count = 200000;
  const SurfaceSamples samples = *SampleSurface(mesh, count, 2);
  std::vector<int> hits(mesh.triangles.size());
  for (const int triangle : samples.triangles) ++hits[static_cast<std::size_t>(triangle)];
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const double expected = count * Area(mesh, i) / SurfaceArea(mesh);
    // Five standard deviations of a binomial count. The first and the last face are where the
    // original failed.
    EXPECT_NEAR(hits[i], expected, 5 * std::sqrt(expected + 1)) << "face " << i;
  }
  EXPECT_EQ(hits[7], 0);
}

TEST(SampleSurface, IsUniformInsideATriangle) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {3, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const int count = 100000;
  const SurfaceSamples samples = *SampleSurface(mesh, count, 3);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  int near_first_corner = 0;  // the quarter of the area that halving the sides cuts off
  for (const Eigen::Vector3d& point : samples.points) {
    mean += point / count;
    near_first_corner += point.x() / 3 + point.y() < 0.5;
  }
  EXPECT_LT((mean - Eigen::Vector3d(1, 1.0 / 3, 0)).norm(), 0.01);
  EXPECT_NEAR(near_first_corner, count / 4, 5 * std::sqrt(count * 3.0 / 16));
}

TEST(SampleSurface, RepeatsWithTheSameSeedAndDiffersWithAnother) {
  const TriangleMesh mesh = Fan();
  const SurfaceSamples first = *SampleSurface(mesh, 1000, 5);
  const SurfaceSamples again = *SampleSurface(mesh, 2000, 5);
  const SurfaceSamples other = *SampleSurface(mesh, 1000, 6);
  int equal = 0;
  for (std::size_t i = 0; i < 1000; ++i) {
    EXPECT_EQ(first.points[i], again.points[i]);  // a longer draw begins like a shorter one
    equal += first.points[i] == other.points[i];
  }
  EXPECT_EQ(equal, 0);
}

TEST(SampleSurface, RefusesAMeshWithoutSurface) {
  TriangleMesh cloud;
  cloud.vertices = {{0, 0, 0}};
  EXPECT_EQ(SampleSurface(cloud, 10, 1).error().code, ErrorCode::kDegenerate);
  cloud.triangles = {{0, 0, 0}};
  EXPECT_EQ(SampleSurface(cloud, 10, 1).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace plumbline
