// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/model_surface.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <tbb/parallel_for.h>

#include "engine/geometry/surface_sampling.h"

namespace plumbline {
namespace {

constexpr int kSamples = 6000;
constexpr std::uint64_t kSampleSeed = 20180908;
constexpr int kLargestOrder = 8;
constexpr std::size_t kSymmetrySamples = 300;
/// Share of the surface that a symmetry may leave out: a knob, a missing screw.
constexpr double kSymmetryExceptions = 0.02;

struct Sides {
  bool front = false, back = false;
};

/// Which sides of a face can be seen from outside: some ray out of a sphere of directions gets
/// away.
Sides SeenSides(const ClosestTriangleSearch& mesh, const Eigen::Vector3d& point,
                const Eigen::Vector3d& normal) {
  constexpr int kDirections = 24;
  constexpr double kGoldenAngle = 2.39996322972865332, kGrazing = 0.2, kOffset_m = 2e-4;
  Sides sides;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections, radius = std::sqrt(1 - z * z);
    const Eigen::Vector3d direction(radius * std::cos(kGoldenAngle * i),
                                    radius * std::sin(kGoldenAngle * i), z);
    const double along = direction.dot(normal);
    if (std::abs(along) < kGrazing) continue;
    bool& side = along > 0 ? sides.front : sides.back;
    if (side) continue;
    side = !mesh.Blocked(point + std::copysign(kOffset_m, along) * normal, direction);
  }
  return sides;
}

/// Centre of mass of the faces.
Eigen::Vector3d Middle(const TriangleMesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0;
  for (const Eigen::Vector3i& corners : mesh.triangles) {
    const auto corner = [&](int i) -> Eigen::Vector3d {
      return mesh.vertices[static_cast<std::size_t>(corners[i])].cast<double>();
    };
    const Eigen::Vector3d a = corner(0), b = corner(1), c = corner(2);
    const double doubled = (b - a).cross(c - a).norm();
    sum += doubled * (a + b + c) / 3;
    area += doubled;
  }
  return sum / area;
}

}  // namespace

Result<std::shared_ptr<const ModelSurface>> ModelSurface::Prepare(const TriangleMesh& model) {
  auto triangles = ClosestTriangleSearch::Build(model);
  if (!triangles) return triangles.error();
  const Result<SurfaceSamples> drawn = SampleSurface(model, kSamples, kSampleSeed);
  if (!drawn) return drawn.error();
  std::vector<Sides> seen(drawn->points.size());
  tbb::parallel_for(std::size_t{0}, seen.size(), [&](std::size_t i) {
    seen[i] = SeenSides(**triangles, drawn->points[i], (*triangles)->Normal(drawn->triangles[i]));
  });
  std::vector<Sides> sides(model.triangles.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    Sides& face = sides[static_cast<std::size_t>(drawn->triangles[i])];
    face.front |= seen[i].front;
    face.back |= seen[i].back;
  }
  std::vector<Face> faces;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Eigen::Vector3d normal = (*triangles)->Normal(static_cast<int>(i));
    const bool flip = sides[i].back && !sides[i].front;
    faces.push_back({flip ? Eigen::Vector3d(-normal) : normal, sides[i].front == sides[i].back});
  }
  OrientedPoints samples;
  std::vector<char> two_sided;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i].front && !seen[i].back) continue;  // inside
    const Eigen::Vector3f normal = (*triangles)->Normal(drawn->triangles[i]).cast<float>();
    samples.points.push_back(drawn->points[i].cast<float>());
    samples.normals.push_back(seen[i].front ? normal : Eigen::Vector3f(-normal));
    two_sided.push_back(seen[i].front && seen[i].back);
  }
  return std::shared_ptr<const ModelSurface>(new ModelSurface(std::move(*triangles),
                                                              std::move(faces), std::move(samples),
                                                              std::move(two_sided), Middle(model)));
}

ModelSurface::ModelSurface(std::unique_ptr<const ClosestTriangleSearch> triangles,
                           std::vector<Face> faces, OrientedPoints samples,
                           std::vector<char> two_sided, const Eigen::Vector3d& middle)
    : triangles_(std::move(triangles)),
      faces_(std::move(faces)),
      samples_(std::move(samples)),
      two_sided_(std::move(two_sided)),
      sample_tree_(samples_.points),
      middle_(middle) {
  for (const Eigen::Vector3f& point : samples_.points) bounds_.extend(point.cast<double>());
}

bool ModelSurface::LooksTheSame(double turn_rad, double tolerance_m) const {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const std::size_t step = samples_.points.size() / kSymmetrySamples;
  std::size_t off = 0;
  for (std::size_t i = 0; i < kSymmetrySamples; ++i) {
    const Eigen::Vector3d point = samples_.points[i * step].cast<double>();
    const Eigen::Vector3d turned = middle_ + turn * (point - middle_);
    if (triangles_->Find(turned).distance_m > tolerance_m) ++off;
  }
  return static_cast<double>(off) <= kSymmetryExceptions * static_cast<double>(kSymmetrySamples);
}

int ModelSurface::SymmetryOrder(double tolerance_m) const {
  const auto same = [&](double degrees) {
    return LooksTheSame(degrees * std::numbers::pi / 180, tolerance_m);
  };
  if (same(37) && same(101) && same(163)) return 0;
  for (int order = kLargestOrder; order > 1; --order) {
    if (same(360.0 / order)) return order;
  }
  return 1;
}

}  // namespace plumbline
