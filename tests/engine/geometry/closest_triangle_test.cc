// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/closest_triangle.h"

#include <vtkCellArray.h>
#include <vtkCellLocator.h>
#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "engine/base/random.h"
#include "engine/geometry/random_vector.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

Eigen::Vector3d RandomPoint(Random& random, double spread) {
  return spread * GaussianVector<3>(random);
}

Eigen::Vector3d Corner(const TriangleMesh& mesh, std::size_t triangle, int corner) {
  return mesh.vertices[static_cast<std::size_t>(mesh.triangles[triangle][corner])].cast<double>();
}

/// Independent of the implementation: projects onto the plane, else the nearest of 3 densely
/// refined edges.
double DistanceByMinimisation(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                              const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  double best = std::numeric_limits<double>::infinity();
  if (normal.norm() > 1e-14) {
    const Eigen::Vector3d n = normal.normalized();
    const Eigen::Vector3d q = p - n.dot(p - a) * n;
    const bool inside = n.dot((b - a).cross(q - a)) >= 0 && n.dot((c - b).cross(q - b)) >= 0 &&
                        n.dot((a - c).cross(q - c)) >= 0;
    if (inside) best = (p - q).norm();
  }
  const Eigen::Vector3d ends[] = {a, b, c, a};
  for (int edge = 0; edge < 3; ++edge) {
    double low = 0, high = 1;  // the distance along a segment is convex
    const auto at = [&](double t) {
      return (ends[edge] + t * (ends[edge + 1] - ends[edge]) - p).norm();
    };
    for (int i = 0; i < 200; ++i) {
      const double left = low + (high - low) / 3, right = high - (high - low) / 3;
      (at(left) < at(right) ? high : low) = at(left) < at(right) ? right : left;
    }
    best = std::min({best, at(0), at(1), at((low + high) / 2)});
  }
  return best;
}

TriangleMesh RandomMesh(int triangles, double spread, double size, std::uint64_t seed) {
  TriangleMesh mesh;
  Random random({.seed = seed});
  for (int i = 0; i < triangles; ++i) {
    const Eigen::Vector3d centre = RandomPoint(random, spread);
    for (int corner = 0; corner < 3; ++corner) {
      mesh.vertices.push_back((centre + RandomPoint(random, size)).cast<float>());
    }
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  return mesh;
}

/// A closed surface: the locators' usual food. `rings` x `rings` quads on a torus.
TriangleMesh Torus(int rings) {
  TriangleMesh mesh;
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < rings; ++j) {
      const double u = 2 * std::numbers::pi * i / rings, v = 2 * std::numbers::pi * j / rings;
      mesh.vertices.emplace_back(Eigen::Vector3d((1 + 0.4 * std::cos(v)) * std::cos(u),
                                                 (1 + 0.4 * std::cos(v)) * std::sin(u),
                                                 0.4 * std::sin(v))
                                     .cast<float>());
      const int i1 = (i + 1) % rings, j1 = (j + 1) % rings;
      mesh.triangles.emplace_back(i * rings + j, i1 * rings + j, i1 * rings + j1);
      mesh.triangles.emplace_back(i * rings + j, i1 * rings + j1, i * rings + j1);
    }
  }
  return mesh;
}

TEST(ClosestPointOnTriangle, AgreesWithMinimisationForFlatLongAndTinyTriangles) {
  Random random({.seed = 11});
  for (int trial = 0; trial < 5000; ++trial) {
    const double size = std::pow(10.0, random.Uniform(-4, 1));
    const Eigen::Vector3d a = RandomPoint(random, 1);
    const Eigen::Vector3d b = a + RandomPoint(random, size);
    Eigen::Vector3d c = a + RandomPoint(random, size);
    if (trial % 5 == 0) c = a + 0.3 * (b - a);  // no area
    if (trial % 5 == 1) c = a + 0.3 * (b - a) + RandomPoint(random, 1e-9);
    if (trial % 50 == 2) c = a;
    const Eigen::Vector3d p = a + RandomPoint(random, trial % 2 == 0 ? size : 1);
    const Eigen::Vector3d closest = ClosestPointOnTriangle(p, a, b, c);
    EXPECT_NEAR((closest - p).norm(), DistanceByMinimisation(p, a, b, c), 1e-9) << trial;
  }
}

TEST(ClosestTriangle, AgreesWithBruteForce) {
  for (const double size : {0.01, 0.1, 2.0}) {
    const TriangleMesh mesh = RandomMesh(500, 1, size, 12);
    const auto search = ClosestTriangleSearch::Build(mesh).value();
    Random random({.seed = 13});
    for (int trial = 0; trial < 500; ++trial) {
      const Eigen::Vector3d p = RandomPoint(random, trial % 3 == 0 ? 10 : 1);
      double best = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Eigen::Vector3d q =
            ClosestPointOnTriangle(p, Corner(mesh, i, 0), Corner(mesh, i, 1), Corner(mesh, i, 2));
        best = std::min(best, (q - p).norm());
      }
      const ClosestPoint found = search->Find(p);
      EXPECT_EQ(found.distance_m, best);  // the same sums: not one triangle may be passed over
      EXPECT_NEAR((found.point - p).norm(), found.distance_m, 1e-15);
    }
  }
}

TEST(ClosestTriangle, IsExactFarFromTheOrigin) {
  TriangleMesh mesh = Torus(40);
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex += Eigen::Vector3f(3000, -2000, 100);
  const auto search = ClosestTriangleSearch::Build(mesh).value();
  Random random({.seed = 14});
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d p = Eigen::Vector3d(3000, -2000, 100) + RandomPoint(random, 1);
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const Eigen::Vector3d q =
          ClosestPointOnTriangle(p, Corner(mesh, i, 0), Corner(mesh, i, 1), Corner(mesh, i, 2));
      best = std::min(best, (q - p).norm());
    }
    EXPECT_EQ(search->Find(p).distance_m, best);
  }
}

TEST(ClosestTriangle, AgreesWithVtksLocator) {
  const TriangleMesh mesh = Torus(150);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Eigen::Vector3f& v : mesh.vertices) points->InsertNextPoint(v.x(), v.y(), v.z());
  vtkNew<vtkCellArray> cells;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const vtkIdType ids[] = {t[0], t[1], t[2]};
    cells->InsertNextCell(3, ids);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  vtkNew<vtkCellLocator> locator;
  locator->SetDataSet(data);
  locator->BuildLocator();
  vtkNew<vtkGenericCell> cell;

  const auto search = ClosestTriangleSearch::Build(mesh).value();
  std::vector<Eigen::Vector3d> queries;
  Random random({.seed = 15});
  for (int i = 0; i < 5000; ++i) queries.push_back(RandomPoint(random, 1));
  std::vector<ClosestPoint> found(queries.size());
  search->Find(queries, found);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    double closest[3], distance2 = 0;
    vtkIdType id = 0;
    int sub = 0;
    locator->FindClosestPoint(queries[i].data(), closest, cell, id, sub, distance2);
    EXPECT_NEAR(found[i].distance_m, std::sqrt(distance2), 1e-9);
    EXPECT_LT((found[i].point - Eigen::Vector3d(closest[0], closest[1], closest[2])).norm(), 1e-6);
  }
}

TEST(ClosestTriangle, TakesTheLowestIndexOfEqualTriangles) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (int i = 0; i < 100; ++i) mesh.triangles.emplace_back(0, 1, 2);
  const auto search = ClosestTriangleSearch::Build(mesh).value();
  EXPECT_EQ(search->Find({0.2, 0.2, 1}).triangle, 0);
  EXPECT_EQ(search->Normal(3), Eigen::Vector3d(0, 0, 1));
}

TEST(ClosestTriangle, KnowsTrianglesWithoutArea) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}};
  const auto search = ClosestTriangleSearch::Build(mesh).value();
  EXPECT_NEAR(search->Find({1.5, 2, 0}).distance_m, 2, 1e-12);
  EXPECT_EQ(search->Normal(0), Eigen::Vector3d::Zero());
}

TEST(ClosestTriangle, RefusesAPointCloud) {
  TriangleMesh cloud;
  cloud.vertices = {{0, 0, 0}};
  EXPECT_EQ(ClosestTriangleSearch::Build(cloud).error().code, ErrorCode::kDegenerate);
}

TEST(ClosestTriangleSearch, ALimitedSearchFindsTheSameOrNothing) {
  const auto search = ClosestTriangleSearch::Build(MakeSphere(0.5f, 12));
  ASSERT_TRUE(search.ok());
  for (const double x : {0.1, 0.3, 0.52, 0.6, 0.9}) {
    const Eigen::Vector3d point(x, 0.01, 0.02);
    const ClosestPoint all = (*search)->Find(point);
    const auto near = (*search)->FindWithin(point, 0.15);
    ASSERT_EQ(near.has_value(), all.distance_m < 0.15) << x;
    if (near) {
      EXPECT_EQ(near->triangle, all.triangle);
      EXPECT_EQ(near->point, all.point);
    }
  }
}

TEST(ClosestTriangleSearch, RaysFromInsideAClosedMeshAreBlocked) {
  const auto search = ClosestTriangleSearch::Build(MakeSphere(0.5f, 12));
  ASSERT_TRUE(search.ok());
  EXPECT_TRUE((*search)->Blocked({0, 0, 0}, {1, 0.1, 0.2}));
  EXPECT_TRUE((*search)->Blocked({2, 0, 0}, {-1, 0.01, 0.02}));
  EXPECT_FALSE((*search)->Blocked({2, 0, 0}, {1, 0.1, 0.2}));
}

}  // namespace
}  // namespace plumbline
