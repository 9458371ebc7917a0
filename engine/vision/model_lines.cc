// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/model_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "engine/geometry/angles.h"
#include "engine/geometry/embree.h"

namespace plumbline {
namespace {

/// Interleaved bits of a pixel: neighbours in this order are neighbours in the image.
std::uint32_t ZOrder(std::uint32_t x, std::uint32_t y) {
  std::uint32_t code = 0;
  for (int bit = 0; bit < 12; ++bit) {
    code |= ((x >> bit) & 1u) << (2 * bit) | ((y >> bit) & 1u) << (2 * bit + 1);
  }
  return code;
}

/// Depth at which the plane of hit `a` meets the ray `ray_b`; 0 if it does not.
float Continued(const RayScene::Hit& a, const Eigen::Vector3f& ray_a,
                const Eigen::Vector3f& ray_b) {
  const float across = a.normal.dot(ray_b);
  if (std::abs(across) < 1e-6f) return 0;
  return std::max(0.0f, a.distance * a.normal.dot(ray_a) / across);
}

/// Whether a contour lies between the rays p and q, p on the near side: q's surface is a step
/// behind p's continued to q, and p's a step before q's continued to p (the rule of
/// engine/render/contour.cc: at a crease, a face seen squarely meets one seen at a grazing angle).
bool IsStep(const RayScene::Hit& p, const Eigen::Vector3f& ray_p, const RayScene::Hit& q,
            const Eigen::Vector3f& ray_q, float step) {
  if (q.distance == 0) return true;
  if (q.distance - p.distance < step) return false;
  const float p_at_q = Continued(p, ray_p, ray_q), q_at_p = Continued(q, ray_q, ray_p);
  return p_at_q > 0 && q.distance - p_at_q > step && (q_at_p == 0 || q_at_p - p.distance > step);
}

/// A hit's plane in inverse depth, which is linear in the image: value at the pixel and slopes per
/// pixel.
struct InversePlane {
  float value = 0;
  Eigen::Vector2f slope{0, 0};
};

class ViewBuilder {
 public:
  ViewBuilder(const RayScene& scene, const ViewCamera& camera, float step,
              const ViewpointModelOptions& options)
      : scene_(scene),
        camera_(camera),
        step_(step),
        inner_weight_(static_cast<float>(options.inner_weight)),
        mark_contrast_(static_cast<float>(options.mark_contrast)),
        rim_m_(static_cast<float>(options.rim_m)),
        crease_cosine_(static_cast<float>(std::cos(options.crease_angle_deg * kRadPerDeg))),
        hits_(static_cast<std::size_t>(camera.size) * camera.size) {
    for (int v = 0; v < camera_.size; ++v) {
      for (int u = 0; u < camera_.size; ++u)
        At(u, v) = scene_.Cast(camera_.origin, camera_.Direction(u, v));
    }
  }

  /// Evenly spaced points along contour and inner lines.
  ModelLines Sample(int count) const {
    std::vector<Candidate> candidates = FindContour();
    if (inner_weight_ > 0) AddInnerLines(candidates);
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return std::tie(a.inner, a.order) < std::tie(b.inner, b.order);
    });
    ModelLines lines;
    double total = 0;
    for (const Candidate& candidate : candidates) total += candidate.length;
    lines.length_px = total;
    double sum = 0, next = 0.5 * total / count;
    for (const Candidate& candidate : candidates) {
      sum += candidate.length;
      if (sum < next) continue;
      lines.points.push_back(candidate.inner ? OnInnerLine(candidate) : Refine(candidate));
      lines.outline_size += candidate.inner ? 0 : 1;
      next += total / count;
    }
    return lines;
  }

 private:
  struct Candidate {
    int u, v;
    Eigen::Vector2f normal;
    float length;
    std::uint32_t order;
    bool inner = false;       ///< A crease or a mark, whose place is known:
    float offset = 0;         ///< From the pixel along `normal` [px].
    float inverse_depth = 0;  ///< There.
  };

  RayScene::Hit& At(int u, int v) { return hits_[static_cast<std::size_t>(v) * camera_.size + u]; }
  const RayScene::Hit& At(int u, int v) const {
    return hits_[static_cast<std::size_t>(v) * camera_.size + u];
  }

  std::vector<Candidate> FindContour() const {
    std::vector<Candidate> found;
    static constexpr int kNeighbours[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (int v = 4; v < camera_.size - 4; ++v) {
      for (int u = 4; u < camera_.size - 4; ++u) {
        const RayScene::Hit& hit = At(u, v);
        if (hit.distance == 0) continue;
        bool on_contour = false;
        for (const auto& n : kNeighbours) {
          on_contour = on_contour || IsStep(hit, camera_.Direction(u, v), At(u + n[0], v + n[1]),
                                            camera_.Direction(u + n[0], v + n[1]), step_);
        }
        if (!on_contour) continue;
        const Eigen::Vector2f normal = OutwardNormal(u, v);
        if (normal.squaredNorm() == 0) continue;
        const float length = 1.0f / std::max(std::abs(normal.x()), std::abs(normal.y()));
        found.push_back({u, v, normal, length,
                         ZOrder(static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v))});
      }
    }
    return found;
  }

  InversePlane PlaneAt(int u, int v) const {
    const RayScene::Hit& hit = At(u, v);
    const float along =
        hit.normal.dot(camera_.Direction(static_cast<float>(u), static_cast<float>(v)));
    const float scale = camera_.pixel / (hit.distance * along);
    return {1.0f / hit.distance,
            scale * Eigen::Vector2f(hit.normal.dot(camera_.right), hit.normal.dot(camera_.down))};
  }

  /// Creases and marks: faces that meet at an angle, or a step of colour, between the pixels before
  /// and after this one, along the axis that crosses the line more squarely. A line between two
  /// pixels is seen from both, so each counts half. (The rule of shaders/likelihood/
  /// atlas_score.comp.)
  void AddInnerLines(std::vector<Candidate>& found) const {
    for (int v = 4; v < camera_.size - 4; ++v) {
      for (int u = 4; u < camera_.size - 4; ++u) {
        for (int axis = 0; axis < 2; ++axis) {
          std::optional<Candidate> line = CreaseAt(u, v, axis);
          if (!line) line = MarkAt(u, v, axis);
          if (line) found.push_back(*line);
        }
      }
    }
  }

  std::optional<Candidate> CreaseAt(int u, int v, int axis) const {
    const int du = axis == 0 ? 1 : 0, dv = 1 - du;
    const RayScene::Hit &p = At(u - du, v - dv), &q = At(u + du, v + dv);
    if (p.distance == 0 || q.distance == 0 || At(u, v).distance == 0) return std::nullopt;
    const Eigen::Vector3f ray_p = Moved(u, v, -1, du, dv), ray_q = Moved(u, v, 1, du, dv);
    // Normals as the camera sees them: meshes may be wound either way.
    const float facing = p.normal.dot(ray_p) * q.normal.dot(ray_q) < 0 ? -1.0f : 1.0f;
    if (facing * p.normal.dot(q.normal) > crease_cosine_) return std::nullopt;
    const InversePlane a = PlaneAt(u - du, v - dv), b = PlaneAt(u + du, v + dv);
    const Eigen::Vector2f across = a.slope - b.slope;
    const float norm = across.norm();
    if (norm == 0) return std::nullopt;
    const Eigen::Vector2f normal = across / norm;
    if (std::abs(normal[axis]) < std::abs(normal[1 - axis])) return std::nullopt;
    // Where the planes meet, along the axis from the pixel; far away they are two surfaces.
    const float at_a = a.value + a.slope[axis], at_b = b.value - b.slope[axis];
    const float meet = (at_b - at_a) / across[axis];
    if (!(std::abs(meet) <= 1.0f)) return std::nullopt;
    Candidate crease{u,
                     v,
                     normal,
                     0.5f * inner_weight_ / std::abs(normal[axis]),
                     ZOrder(static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v)),
                     true};
    crease.offset = meet * normal[axis];
    Eigen::Vector2f step = crease.offset * normal;
    step[axis] += 1.0f;  // from the pixel before
    crease.inverse_depth = a.value + a.slope.dot(step);
    return crease.inverse_depth > 0 ? std::optional(crease) : std::nullopt;
  }

  std::optional<Candidate> MarkAt(int u, int v, int axis) const {
    const RayScene::Hit& hit = At(u, v);
    if (hit.distance == 0) return std::nullopt;
    // All on one surface: elsewhere it is the contour's.
    static constexpr int kNeighbours[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (const auto& n : kNeighbours) {
      const RayScene::Hit& other = At(u + n[0], v + n[1]);
      if (other.distance == 0 || std::abs(other.distance - hit.distance) > step_)
        return std::nullopt;
    }
    const int du = axis == 0 ? 1 : 0, dv = 1 - du;
    const float before = At(u - du, v - dv).luminance, after = At(u + du, v + dv).luminance;
    if (std::abs(after - before) < mark_contrast_) return std::nullopt;
    const Eigen::Vector2f normal = LuminanceGradient(u, v).normalized();
    if (!(std::abs(normal[axis]) >= std::abs(normal[1 - axis]))) return std::nullopt;
    Candidate mark{u,
                   v,
                   normal,
                   0.5f * inner_weight_ / std::abs(normal[axis]),
                   ZOrder(static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v)),
                   true};
    // Halfway between the colours of the pixels before and after, by bisection along the axis.
    float low = -1, high = 1;
    RayScene::Hit there = hit;
    for (int i = 0; i < 5; ++i) {
      const float middle = 0.5f * (low + high);
      there = scene_.Cast(camera_.origin, Moved(u, v, middle, du, dv));
      if (there.distance == 0) return std::nullopt;
      const bool past = std::abs(there.luminance - before) > std::abs(there.luminance - after);
      (past ? high : low) = middle;
    }
    mark.offset = 0.5f * (low + high) * normal[axis];
    mark.inverse_depth = 1.0f / there.distance;
    return mark;
  }

  /// Of the surface that the pixel shows, over a window.
  Eigen::Vector2f LuminanceGradient(int u, int v) const {
    const RayScene::Hit& hit = At(u, v);
    Eigen::Vector2f gradient = Eigen::Vector2f::Zero();
    constexpr int kRadius = 3;
    for (int dv = -kRadius; dv <= kRadius; ++dv) {
      for (int du = -kRadius; du <= kRadius; ++du) {
        const RayScene::Hit& other = At(u + du, v + dv);
        if (other.distance == 0 || std::abs(other.distance - hit.distance) > 2 * step_) continue;
        const float weight = std::exp(-0.5f * (du * du + dv * dv) / (1.5f * 1.5f));
        gradient += weight * (other.luminance - hit.luminance) * Eigen::Vector2f(du, dv);
      }
    }
    return gradient;
  }

  Eigen::Vector3f Moved(int u, int v, float by, int du, int dv) const {
    return camera_.Direction(static_cast<float>(u) + by * static_cast<float>(du),
                             static_cast<float>(v) + by * static_cast<float>(dv));
  }

  ContourPoint OnInnerLine(const Candidate& line) const {
    const Eigen::Vector3f ray =
        camera_.Direction(static_cast<float>(line.u) + line.offset * line.normal.x(),
                          static_cast<float>(line.v) + line.offset * line.normal.y());
    const Eigen::Vector3f across = line.normal.x() * camera_.right + line.normal.y() * camera_.down;
    return {camera_.origin + ray / line.inverse_depth, across.normalized()};
  }

  /// From the side that continues this pixel's surface to the side that lies behind it, in the
  /// image.
  Eigen::Vector2f OutwardNormal(int u, int v) const {
    const RayScene::Hit& hit = At(u, v);
    const Eigen::Vector3f ray = camera_.Direction(u, v);
    Eigen::Vector2f toward_near = Eigen::Vector2f::Zero();
    constexpr int kRadius = 3;
    for (int dv = -kRadius; dv <= kRadius; ++dv) {
      for (int du = -kRadius; du <= kRadius; ++du) {
        const RayScene::Hit& other = At(u + du, v + dv);
        const bool near_side = other.distance != 0 && other.distance < hit.distance + step_ * 2 &&
                               !IsStep(hit, ray, other, camera_.Direction(u + du, v + dv), step_);
        if (!near_side) continue;
        const float weight = std::exp(-0.5f * (du * du + dv * dv) / (1.5f * 1.5f));
        toward_near += weight * Eigen::Vector2f(du, dv);
      }
    }
    const float norm = toward_near.norm();
    return norm > 0.2f ? Eigen::Vector2f(-toward_near / norm) : Eigen::Vector2f(0, 0);
  }

  /// Finds the contour between the pixel and the outside by bisection.
  ContourPoint Refine(const Candidate& candidate) const {
    const RayScene::Hit& hit = At(candidate.u, candidate.v);
    const Eigen::Vector3f ray = camera_.Direction(candidate.u, candidate.v);
    float inside = 0, outside = 1.5f;
    RayScene::Hit last = hit;
    Eigen::Vector3f last_ray = ray;
    for (int i = 0; i < 6; ++i) {
      const float middle = 0.5f * (inside + outside);
      const Eigen::Vector3f direction = camera_.Direction(
          candidate.u + middle * candidate.normal.x(), candidate.v + middle * candidate.normal.y());
      const RayScene::Hit there = scene_.Cast(camera_.origin, direction);
      if (IsStep(hit, ray, there, direction, step_)) {
        outside = middle;
      } else {
        inside = middle;
        last = there;
        last_ray = direction;
      }
    }
    const Eigen::Vector3f across =
        candidate.normal.x() * camera_.right + candidate.normal.y() * camera_.down;
    return {camera_.origin + last.distance * last_ray, across.normalized(),
            RimOf(candidate, inside, last.distance), last.luminance};
  }

  /// How far inside of the contour, which lies `at` pixels along the normal, the first mark is [m].
  float RimOf(const Candidate& candidate, float at, float depth) const {
    constexpr float kStep_px = 0.5f;
    constexpr std::size_t kApart = 4;  ///< Steps over which a colour changes, as of MarkAt.
    const auto cast = [&](float inwards) {
      const float by = at - inwards;
      const Eigen::Vector3f ray =
          camera_.Direction(static_cast<float>(candidate.u) + by * candidate.normal.x(),
                            static_cast<float>(candidate.v) + by * candidate.normal.y());
      return std::pair(scene_.Cast(camera_.origin, ray), ray);
    };
    const float metres_per_pixel = camera_.pixel * depth;
    std::vector<float> luminance;
    auto [last, last_ray] = cast(kStep_px);
    for (float inwards = kStep_px; inwards * metres_per_pixel <= rim_m_; inwards += kStep_px) {
      const auto [hit, ray] = cast(inwards);
      if (hit.distance == 0 || IsStep(hit, ray, last, last_ray, step_) ||
          IsStep(last, last_ray, hit, ray, step_)) {
        return 0;
      }
      luminance.push_back(hit.luminance);
      const std::size_t now = luminance.size() - 1;
      const float before = luminance[now - std::min(now, kApart)];
      if (std::abs(hit.luminance - before) >= mark_contrast_) {
        // Halfway between the two colours.
        std::size_t edge = now;
        while (edge > 0 &&
               std::abs(luminance[edge - 1] - before) > 0.5f * std::abs(hit.luminance - before))
          --edge;
        return (static_cast<float>(edge) + 0.5f) * kStep_px * metres_per_pixel;
      }
      last = hit;
      last_ray = ray;
    }
    return 0;
  }

  const RayScene& scene_;
  const ViewCamera& camera_;
  float step_, inner_weight_, mark_contrast_, rim_m_, crease_cosine_;
  std::vector<RayScene::Hit> hits_;
};

}  // namespace

struct RayScene::Embree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  ~Embree() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

RayScene::RayScene(const TriangleMesh& mesh) : mesh_(mesh), embree_(std::make_unique<Embree>()) {
  embree_->device = rtcNewDevice(nullptr);
  embree_->scene = rtcNewScene(embree_->device);
  rtcSetSceneFlags(embree_->scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(embree_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    std::copy_n(mesh.vertices[i].data(), 3, vertices + 3 * i);
  }
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k)
      indices[3 * i + k] = static_cast<std::uint32_t>(mesh.triangles[i][k]);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(embree_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(embree_->scene);
}

RayScene::~RayScene() = default;

RayScene::Hit RayScene::Cast(const Eigen::Vector3f& origin,
                             const Eigen::Vector3f& direction) const {
  RTCRayHit ray{};
  std::copy_n(origin.data(), 3, &ray.ray.org_x);
  std::copy_n(direction.data(), 3, &ray.ray.dir_x);
  ray.ray.tnear = 1e-4f;
  ray.ray.tfar = 1e9f;
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RayContext context;
  InitRayContext(context);
  TraceRay(embree_->scene, context, ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  Hit hit{ray.ray.tfar, Eigen::Vector3f(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z).normalized()};
  if (!mesh_.colors.empty()) {
    const Eigen::Vector3i& corners = mesh_.triangles[ray.hit.primID];
    const auto at = [&](int corner) {
      return Luminance(mesh_.colors[static_cast<std::size_t>(corners[corner])]);
    };
    hit.luminance = (1 - ray.hit.u - ray.hit.v) * at(0) + ray.hit.u * at(1) + ray.hit.v * at(2);
  }
  return hit;
}

ViewCamera CameraAt(const Eigen::Vector3f& center, const Eigen::Vector3f& from_center,
                    float distance, float radius, int size) {
  ViewCamera camera;
  camera.origin = center + distance * from_center;
  camera.forward = -from_center;
  camera.right = camera.forward.cross(Eigen::Vector3f::UnitZ()).normalized();
  camera.down = camera.forward.cross(camera.right);
  // The bounding sphere, with a margin of 6 pixels; at most 130 degrees wide when the camera is
  // close.
  const float sine = std::min(radius / distance, std::sin(65.0f * static_cast<float>(kRadPerDeg)));
  const float half_width = sine / std::sqrt(1.0f - sine * sine);
  camera.pixel = 2.0f * half_width / (size - 12);
  camera.size = size;
  return camera;
}

ModelLines SampleLines(const RayScene& scene, const ViewCamera& camera, float step,
                       const ViewpointModelOptions& options) {
  return ViewBuilder(scene, camera, step, options).Sample(options.points);
}

}  // namespace plumbline
