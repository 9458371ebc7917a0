// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/traced_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/check.h"
#include "engine/geometry/embree.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

/// Longer edges are cut, so that light lattices and mean colours stay local; where light is
/// computed at few points, at so many spacings.
constexpr float kMaxEdgeM = 0.5f, kMaxEdgeSpacings = 4;
/// Rays start this far off, so that they miss the surface that they leave.
constexpr float kNear = 1e-4f;

RTCRay MakeRay(const Vector3f& origin, const Vector3f& direction, float far) {
  RTCRay ray{};
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tnear = kNear;
  ray.tfar = far;
  ray.mask = ~0U;
  return ray;
}

}  // namespace

struct TracedScene::Embree {
  RTCDevice device = nullptr;
  RTCScene all = nullptr;      ///< Geometry 0: what casts shadows; geometry 1: what lets light in.
  RTCScene shadows = nullptr;  ///< Geometry 0 alone.
  ~Embree() {
    if (all) rtcReleaseScene(all);
    if (shadows) rtcReleaseScene(shadows);
    if (device) rtcReleaseDevice(device);
  }

  RTCGeometry MakeGeometry(const std::vector<Vector3f>& vertices,
                           std::span<const Triangle> triangles) const {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               vertices.size()));
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), triangles.size()));
    PLB_CHECK(points != nullptr && (indices != nullptr || triangles.empty()))
        << "Embree is out of memory";
    for (const Vector3f& vertex : vertices) {
      for (int axis = 0; axis < 3; ++axis) *points++ = vertex[axis];
    }
    for (const Triangle& triangle : triangles) {
      for (int corner = 0; corner < 3; ++corner)
        *indices++ = static_cast<unsigned>(triangle.corners[corner]);
    }
    rtcCommitGeometry(geometry);
    return geometry;
  }
};

TracedScene::TracedScene(std::span<const RoomPart> parts) : embree_(std::make_unique<Embree>()) {
  PLB_CHECK(parts.size() < std::numeric_limits<std::uint16_t>::max());
  for (const bool panes : {false, true}) {
    if (panes) first_pane_ = static_cast<std::uint32_t>(triangles_.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].lets_light_in == panes) AddPart(parts[i], static_cast<std::uint16_t>(i));
    }
  }
  embree_->device = rtcNewDevice(nullptr);
  PLB_CHECK(embree_->device != nullptr) << "Embree cannot start";
  embree_->all = rtcNewScene(embree_->device);
  embree_->shadows = rtcNewScene(embree_->device);
  const std::span<const Triangle> triangles(triangles_);
  const RTCGeometry solid = embree_->MakeGeometry(vertices_, triangles.subspan(0, first_pane_));
  const RTCGeometry panes = embree_->MakeGeometry(vertices_, triangles.subspan(first_pane_));
  rtcAttachGeometryByID(embree_->all, solid, 0);
  rtcAttachGeometryByID(embree_->all, panes, 1);
  rtcAttachGeometryByID(embree_->shadows, solid, 0);
  rtcReleaseGeometry(solid);
  rtcReleaseGeometry(panes);
  rtcSetSceneBuildQuality(embree_->all, RTC_BUILD_QUALITY_HIGH);
  rtcSetSceneBuildQuality(embree_->shadows, RTC_BUILD_QUALITY_HIGH);
  rtcCommitScene(embree_->all);
  rtcCommitScene(embree_->shadows);
}

TracedScene::~TracedScene() = default;

void TracedScene::AddPart(const RoomPart& part, std::uint16_t index) {
  PaintedMesh mesh = part.body.mesh;
  Refine(mesh, std::max(kMaxEdgeM, kMaxEdgeSpacings * part.light_spacing_m));
  const int first_vertex = static_cast<int>(vertices_.size());
  const auto first_material = static_cast<std::uint32_t>(materials_.size());
  vertices_.insert(vertices_.end(), mesh.vertices.begin(), mesh.vertices.end());
  normals_.insert(normals_.end(), mesh.normals.begin(), mesh.normals.end());
  texture_.insert(texture_.end(), mesh.texture.begin(), mesh.texture.end());
  materials_.insert(materials_.end(), part.body.materials.begin(), part.body.materials.end());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle triangle;
    triangle.corners = mesh.triangles[t] + Eigen::Vector3i::Constant(first_vertex);
    triangle.material = first_material + static_cast<std::uint32_t>(mesh.paints[t]);
    triangle.part = index;
    triangle.instance = static_cast<std::uint16_t>(part.instance);
    triangle.light_spacing_m = part.light_spacing_m;
    triangle.lets_light_in = part.lets_light_in;
    triangles_.push_back(triangle);
    const Hit middle{static_cast<std::uint32_t>(triangles_.size() - 1), 0, 1 / 3.0f, 1 / 3.0f};
    triangles_.back().mean_color =
        PatternColor(materials_[triangle.material], Texture(middle), 0.2f);
  }
}

TracedScene::Hit TracedScene::Trace(const Vector3f& origin, const Vector3f& direction) const {
  RTCRayHit query{};
  query.ray = MakeRay(origin, direction, std::numeric_limits<float>::infinity());
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RayContext context;
  InitRayContext(context);
  TraceRay(embree_->all, context, query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {query.hit.primID + (query.hit.geomID == 0 ? 0 : first_pane_), query.ray.tfar, query.hit.u,
          query.hit.v};
}

std::array<TracedScene::Hit, 4> TracedScene::Trace4(
    const std::array<Vector3f, 4>& origins, const std::array<Vector3f, 4>& directions) const {
  alignas(16) RTCRayHit4 query{};
  for (std::size_t i = 0; i < 4; ++i) {
    query.ray.org_x[i] = origins[i].x();
    query.ray.org_y[i] = origins[i].y();
    query.ray.org_z[i] = origins[i].z();
    query.ray.dir_x[i] = directions[i].x();
    query.ray.dir_y[i] = directions[i].y();
    query.ray.dir_z[i] = directions[i].z();
    query.ray.tnear[i] = kNear;
    query.ray.tfar[i] = std::numeric_limits<float>::infinity();
    query.ray.mask[i] = ~0U;
    query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  RayContext context;
  InitRayContext(context);
  TraceRays4(embree_->all, context, query);
  std::array<Hit, 4> hits;
  for (std::size_t i = 0; i < 4; ++i) {
    if (query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const std::uint32_t first = query.hit.geomID[i] == 0 ? 0 : first_pane_;
    hits[i] = {query.hit.primID[i] + first, query.ray.tfar[i], query.hit.u[i], query.hit.v[i]};
  }
  return hits;
}

bool TracedScene::Blocked(const Vector3f& origin, const Vector3f& direction, float distance) const {
  RTCRay ray = MakeRay(origin, direction, distance);
  RayContext context;
  InitRayContext(context);
  TraceShadowRay(embree_->shadows, context, ray);
  return ray.tfar < 0;
}

Vector3f TracedScene::FaceNormal(std::uint32_t triangle) const {
  const Eigen::Vector3i& c = triangles_[triangle].corners;
  const Vector3f& a = vertices_[static_cast<std::size_t>(c[0])];
  return (vertices_[static_cast<std::size_t>(c[1])] - a)
      .cross(vertices_[static_cast<std::size_t>(c[2])] - a)
      .normalized();
}

}  // namespace plumbline
