// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <memory>
#include <vector>

#include "engine/base/check.h"
#include "engine/geometry/embree.h"
#include "engine/render/renderer.h"

namespace plumbline {
namespace {

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using Scene = std::unique_ptr<RTCSceneTy, ReleaseScene>;

/// What a ray carries: the id that it passes through (-1 none).
struct Context {
  RayContext base;
  int ignored_id = -1;
};

void IgnoreId(const RTCFilterFunctionNArguments* arguments) {
  const auto* instance = static_cast<const RenderInstance*>(arguments->geometryUserPtr);
  const auto* context = reinterpret_cast<const Context*>(arguments->context);
  if (instance->id == context->ignored_id) arguments->valid[0] = 0;
}

void AddInstance(RTCDevice device, RTCScene scene, const TriangleMesh& mesh,
                 const RenderInstance& instance) {
  if (mesh.triangles.empty()) return;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const Eigen::Vector3f in_cam =
        (instance.cam_from_object * (instance.scale * vertex.cast<double>())).cast<float>();
    vertices = std::copy(in_cam.data(), in_cam.data() + 3, vertices);
  }
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    indices = std::copy(triangle.data(), triangle.data() + 3, indices);
  }
  rtcSetGeometryUserData(geometry, const_cast<RenderInstance*>(&instance));
  rtcSetGeometryIntersectFilterFunction(geometry, IgnoreId);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

struct Hit {
  float depth = 0;
  int id = 0;
};

Hit Cast(RTCScene scene, const Eigen::Vector2d& bearing, float near_m, int ignored_id) {
  RTCRayHit ray{};
  // With direction (X/Z, Y/Z, 1) the distance along the ray is Z.
  ray.ray.dir_x = static_cast<float>(bearing.x());
  ray.ray.dir_y = static_cast<float>(bearing.y());
  ray.ray.dir_z = 1.0f;
  ray.ray.tnear = near_m;
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  Context context;
  InitRayContext(context.base);
  context.ignored_id = ignored_id;
  TraceRay(scene, context.base, ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const auto* instance = static_cast<const RenderInstance*>(
      rtcGetGeometryUserData(rtcGetGeometry(scene, ray.hit.geomID)));
  return {ray.ray.tfar, instance->id};
}

}  // namespace

RenderedMaps RayCast(const PinholeCamera& camera, std::span<const TriangleMesh* const> meshes,
                     std::span<const RenderInstance> instances, const RenderOptions& options) {
  const Device device(rtcNewDevice(nullptr));
  PLB_CHECK(device != nullptr) << "Embree gives no device";
  const Scene scene(rtcNewScene(device.get()));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  for (const RenderInstance& instance : instances) {
    PLB_CHECK(instance.mesh >= 0 && static_cast<std::size_t>(instance.mesh) < meshes.size())
        << "no mesh " << instance.mesh;
    AddInstance(device.get(), scene.get(), *meshes[static_cast<std::size_t>(instance.mesh)],
                instance);
  }
  rtcCommitScene(scene.get());
  RenderedMaps maps;
  const cv::Size size(camera.width, camera.height);
  maps.depth = cv::Mat(size, CV_32F, cv::Scalar(0));
  maps.id = cv::Mat(size, CV_16U, cv::Scalar(0));
  if (options.second_layer) {
    maps.second_depth = cv::Mat(size, CV_32F, cv::Scalar(0));
    maps.second_id = cv::Mat(size, CV_16U, cv::Scalar(0));
  }
  const auto near_m = static_cast<float>(options.near_m);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const Eigen::Vector2d bearing = camera.Bearing({x, y});
      const Hit first = Cast(scene.get(), bearing, near_m, -1);
      maps.depth.at<float>(y, x) = first.depth;
      maps.id.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(first.id);
      if (!options.second_layer || first.id == 0) continue;
      const Hit second = Cast(scene.get(), bearing, near_m, first.id);
      maps.second_depth.at<float>(y, x) = second.depth;
      maps.second_id.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(second.id);
    }
  }
  if (options.contour) maps.contour = ContourOf(maps.depth, maps.id, options.contour_step_m);
  return maps;
}

}  // namespace plumbline
