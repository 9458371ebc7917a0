// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/surface_sampling.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include <Eigen/Geometry>

#include "engine/base/check.h"
#include "engine/base/random.h"

namespace plumbline {
namespace {

struct Corners {
  Eigen::Vector3d a, b, c;
};

Corners CornersOf(const TriangleMesh& mesh, std::size_t triangle) {
  const Eigen::Vector3i& t = mesh.triangles[triangle];
  const auto corner = [&](int i) -> Eigen::Vector3d {
    return mesh.vertices[static_cast<std::size_t>(t[i])].cast<double>();
  };
  return {corner(0), corner(1), corner(2)};
}

/// Entry i is the area of triangles 0 .. i.
std::vector<double> CumulativeAreas(const TriangleMesh& mesh) {
  std::vector<double> cumulative(mesh.triangles.size());
  double sum = 0;
  for (std::size_t i = 0; i < cumulative.size(); ++i) {
    const Corners t = CornersOf(mesh, i);
    sum += 0.5 * (t.b - t.a).cross(t.c - t.a).norm();
    cumulative[i] = sum;
  }
  return cumulative;
}

}  // namespace

double SurfaceArea(const TriangleMesh& mesh) {
  return mesh.triangles.empty() ? 0.0 : CumulativeAreas(mesh).back();
}

Result<SurfaceSamples> SampleSurface(const TriangleMesh& mesh, int count, std::uint64_t seed) {
  PLB_CHECK(count >= 0) << count;
  const std::vector<double> cumulative = CumulativeAreas(mesh);
  if (cumulative.empty() || !(cumulative.back() > 0)) {
    return Error{ErrorCode::kDegenerate,
                 "a mesh without a face of positive area has no surface to sample"};
  }
  SurfaceSamples samples;
  samples.points.resize(static_cast<std::size_t>(count));
  samples.triangles.resize(static_cast<std::size_t>(count));
  tbb::parallel_for(0, count, [&](int i) {
    Random random({.seed = seed, .particle = static_cast<std::uint32_t>(i)});
    // The first triangle whose cumulative area exceeds the target: one without area is never it.
    const double target = random.Uniform() * cumulative.back();
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end() - 1, target);
    const auto triangle = static_cast<std::size_t>(found - cumulative.begin());
    double u = random.Uniform();
    double v = random.Uniform();
    if (u + v > 1) {  // fold the parallelogram onto the triangle
      u = 1 - u;
      v = 1 - v;
    }
    const Corners t = CornersOf(mesh, triangle);
    samples.points[static_cast<std::size_t>(i)] = t.a + u * (t.b - t.a) + v * (t.c - t.a);
    samples.triangles[static_cast<std::size_t>(i)] = static_cast<int>(triangle);
  });
  return samples;
}

}  // namespace plumbline
