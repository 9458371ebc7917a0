// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/closest_triangle.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "engine/geometry/embree.h"

namespace plumbline {
namespace {

/// Closest point on the segment a b.
Eigen::Vector3d OnSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                          const Eigen::Vector3d& b) {
  const Eigen::Vector3d edge = b - a;
  const double length2 = edge.squaredNorm();
  if (!(length2 > 0)) return a;
  return a + std::clamp((p - a).dot(edge) / length2, 0.0, 1.0) * edge;
}

Eigen::Vector3d OnNearestEdge(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                              const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  Eigen::Vector3d best = OnSegment(p, a, b);
  for (const Eigen::Vector3d& candidate : {OnSegment(p, b, c), OnSegment(p, c, a)}) {
    if ((candidate - p).squaredNorm() < (best - p).squaredNorm()) best = candidate;
  }
  return best;
}

/// The bits of x (21 of them) with two zeros behind each.
std::uint64_t Spread(std::uint64_t x) {
  x = (x | x << 32) & 0x1F00000000FFFFull;
  x = (x | x << 16) & 0x1F0000FF0000FFull;
  x = (x | x << 8) & 0x100F00F00F00F00Full;
  x = (x | x << 4) & 0x10C30C30C30C30C3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}

/// Indices of `points` in Morton order: neighbours in the list are mostly neighbours in space.
std::vector<std::uint32_t> AlongSpaceFillingCurve(std::span<const Eigen::Vector3d> points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  const double size = points.empty() ? 0 : box.sizes().maxCoeff();
  const double scale = size > 0 ? 0x1FFFFF / size : 0;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const Eigen::Vector3d cell = (points[i] - box.min()) * scale;
    keys[i] = {Spread(static_cast<std::uint64_t>(cell.x())) |
                   Spread(static_cast<std::uint64_t>(cell.y())) << 1 |
                   Spread(static_cast<std::uint64_t>(cell.z())) << 2,
               static_cast<std::uint32_t>(i)};
  });
  tbb::parallel_sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = keys[i].second;
  return order;
}

}  // namespace

Eigen::Vector3d ClosestPointOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                       const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a;
  const Eigen::Vector3d ac = c - a;
  // Slivers: the barycentric denominators below would be rounding error.
  if (ab.cross(ac).squaredNorm() <= 1e-24 * ab.squaredNorm() * ac.squaredNorm())
    return OnNearestEdge(p, a, b, c);
  const Eigen::Vector3d ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

class ClosestTriangleSearch::Implementation {
 public:
  explicit Implementation(const TriangleMesh& mesh)
      : vertices_(mesh.vertices), triangles_(mesh.triangles) {
    vertices_.reserve(vertices_.size() + 1);  // Embree reads 16 bytes at the last vertex
    device_ = rtcNewDevice(nullptr);
    PLB_CHECK(device_ != nullptr) << "Embree cannot start: error " << rtcGetDeviceError(nullptr);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               vertices_.data(), 0, sizeof(Eigen::Vector3f), vertices_.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               triangles_.data(), 0, sizeof(Eigen::Vector3i), triangles_.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~Implementation() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  /// `guess`: a triangle that may be near, -1 for none. It bounds the search; the result does not
  /// depend on it.
  ClosestPoint Find(const Eigen::Vector3d& point, int guess,
                    double within_m = std::numeric_limits<double>::infinity()) const {
    Search search{this, point, within_m * within_m, {}};
    RTCPointQuery query{};
    query.x = static_cast<float>(point.x());
    query.y = static_cast<float>(point.y());
    query.z = static_cast<float>(point.z());
    query.radius =
        std::isfinite(within_m) ? search.Radius() : std::numeric_limits<float>::infinity();
    if (guess >= 0) {
      search.Try(guess);
      query.radius = search.Radius();
    }
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &query, &context, &Visit, &search);
    search.best.distance_m = std::sqrt(search.distance2);
    return search.best;
  }

  bool Blocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
    RayContext context;
    InitRayContext(context);
    RTCRay ray{};
    ray.org_x = static_cast<float>(origin.x());
    ray.org_y = static_cast<float>(origin.y());
    ray.org_z = static_cast<float>(origin.z());
    ray.dir_x = static_cast<float>(direction.x());
    ray.dir_y = static_cast<float>(direction.y());
    ray.dir_z = static_cast<float>(direction.z());
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = ~0u;
    TraceShadowRay(scene_, context, ray);
    return ray.tfar < 0;
  }

  Eigen::Vector3d Normal(int triangle) const {
    const auto [a, b, c] = Corners(static_cast<std::size_t>(triangle));
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    const double length = normal.norm();
    return length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
  }

 private:
  struct Search {
    const Implementation* mesh;
    Eigen::Vector3d point;
    double distance2;
    ClosestPoint best;

    /// True if the search may become narrower.
    bool Try(int triangle) {
      const auto [a, b, c] = mesh->Corners(static_cast<std::size_t>(triangle));
      const Eigen::Vector3d closest = ClosestPointOnTriangle(point, a, b, c);
      const double candidate2 = (closest - point).squaredNorm();
      const bool nearer = candidate2 < distance2;
      if (nearer || (candidate2 == distance2 && triangle < best.triangle)) {
        best.point = closest;
        best.triangle = triangle;
        distance2 = candidate2;
      }
      return nearer;
    }
    /// Wide enough for the rounding of the point to float, so that no nearer triangle is passed
    /// over.
    float Radius() const {
      const double margin = 4 * std::numeric_limits<float>::epsilon() * point.lpNorm<1>();
      return static_cast<float>((std::sqrt(distance2) + margin) * 1.000001);
    }
  };

  std::array<Eigen::Vector3d, 3> Corners(std::size_t triangle) const {
    const Eigen::Vector3i& t = triangles_[triangle];
    const auto corner = [&](int i) -> Eigen::Vector3d {
      return vertices_[static_cast<std::size_t>(t[i])].cast<double>();
    };
    return {corner(0), corner(1), corner(2)};
  }

  /// Embree finds the candidates in single precision; what decides is computed in double.
  static bool Visit(RTCPointQueryFunctionArguments* arguments) {
    auto& search = *static_cast<Search*>(arguments->userPtr);
    if (!search.Try(static_cast<int>(arguments->primID))) return false;
    arguments->query->radius = search.Radius();
    return true;
  }

  std::vector<Eigen::Vector3f> vertices_;
  std::vector<Eigen::Vector3i> triangles_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

Result<std::unique_ptr<ClosestTriangleSearch>> ClosestTriangleSearch::Build(
    const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) {
    return Error{ErrorCode::kDegenerate,
                 "a mesh without triangles has no surface to measure distances to"};
  }
  return std::unique_ptr<ClosestTriangleSearch>(
      new ClosestTriangleSearch(std::make_unique<Implementation>(mesh)));
}

ClosestTriangleSearch::ClosestTriangleSearch(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
ClosestTriangleSearch::~ClosestTriangleSearch() = default;

ClosestPoint ClosestTriangleSearch::Find(const Eigen::Vector3d& point) const {
  return implementation_->Find(point, -1);
}

void ClosestTriangleSearch::Find(std::span<const Eigen::Vector3d> points,
                                 std::span<ClosestPoint> closest) const {
  PLB_CHECK(points.size() == closest.size())
      << points.size() << " points, room for " << closest.size();
  const std::vector<std::uint32_t> order = AlongSpaceFillingCurve(points);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 1024),
                    [&](const auto& range) {
                      int guess = -1;  // the answer of a neighbour, which is near
                      for (std::size_t i = range.begin(); i != range.end(); ++i) {
                        closest[order[i]] = implementation_->Find(points[order[i]], guess);
                        guess = closest[order[i]].triangle;
                      }
                    });
}

std::optional<ClosestPoint> ClosestTriangleSearch::FindWithin(const Eigen::Vector3d& point,
                                                              double within_m) const {
  const ClosestPoint closest = implementation_->Find(point, -1, within_m);
  return closest.triangle < 0 ? std::nullopt : std::optional(closest);
}

bool ClosestTriangleSearch::Blocked(const Eigen::Vector3d& origin,
                                    const Eigen::Vector3d& direction) const {
  return implementation_->Blocked(origin, direction);
}

Eigen::Vector3d ClosestTriangleSearch::Normal(int triangle) const {
  return implementation_->Normal(triangle);
}

}  // namespace plumbline
