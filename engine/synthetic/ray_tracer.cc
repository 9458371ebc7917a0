// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/ray_tracer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "engine/base/random.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

struct FloatPose {
  Eigen::Matrix3f rotation;
  Vector3f origin;
};

FloatPose ToFloat(const Eigen::Isometry3d& pose) {
  return {pose.linear().cast<float>(), pose.translation().cast<float>()};
}

}  // namespace

Result<std::unique_ptr<const RayTracer>> RayTracer::Create(const Room& room, int light_rays,
                                                           const WorkContext& context) {
  std::unique_ptr<RayTracer> tracer(new RayTracer(room));
  Result<LightMap> light =
      LightMap::Compute(tracer->scene_, room.lights, room.sun, light_rays, context);
  if (!light) return light.error();
  tracer->light_ = std::move(*light);
  tracer->exposure_ = 0.55f / std::max(1e-6f, tracer->light_.MeanLuminance());
  return std::unique_ptr<const RayTracer>(std::move(tracer));
}

Vector3f RayTracer::Diffuse(const TracedScene::Hit& hit, float footprint_m) const {
  const TracedScene::Triangle& triangle = scene_.triangles()[hit.triangle];
  const Material& material = scene_.material(triangle);
  const Vector3f color = PatternColor(material, scene_.Texture(hit), footprint_m);
  if (triangle.lets_light_in) return color * material.emission;
  return color.cwiseProduct(light_.At(hit) + Vector3f::Constant(material.emission));
}

Vector3f RayTracer::ScannedColor(const TracedScene::Hit& hit, float footprint_m) const {
  return Diffuse(hit, footprint_m);
}

Vector3f RayTracer::Radiance(const Vector3f& origin, const Vector3f& direction, float pixel_angle,
                             const Sample& sample) const {
  const TracedScene::Hit hit = scene_.Trace(origin, direction);
  if (!hit.valid()) return Vector3f::Zero();
  const TracedScene::Triangle& triangle = scene_.triangles()[hit.triangle];
  const Material& material = scene_.material(triangle);
  const Vector3f normal = scene_.ShadingNormal(hit);
  const float facing = std::abs(normal.dot(direction));
  const float footprint = hit.distance * pixel_angle / std::sqrt(std::max(0.08f, facing));
  const Vector3f diffuse = Diffuse(hit, footprint);
  if (material.gloss <= 0) return diffuse;
  const float grazing = 1 - facing;
  const float schlick = material.gloss + (1 - material.gloss) * 0.55f * grazing * grazing *
                                             grazing * grazing * grazing;
  Vector3f mirrored = direction - 2 * normal.dot(direction) * normal;
  const Vector3f side = mirrored.unitOrthogonal();
  const float radius = material.roughness * std::sqrt(sample.gloss_u);
  mirrored +=
      radius * (std::cos(sample.gloss_v) * side + std::sin(sample.gloss_v) * mirrored.cross(side));
  mirrored.normalize();
  const float below = mirrored.dot(normal);
  if (below < 0.01f) mirrored = (mirrored + (0.01f - below) * normal).normalized();
  const Vector3f point = origin + hit.distance * direction + 1e-3f * normal;
  const TracedScene::Hit reflected = scene_.Trace(point, mirrored);
  if (!reflected.valid()) return diffuse;
  // Bright windows would sparkle at few samples a pixel.
  const Vector3f seen = Diffuse(reflected, 0.02f + reflected.distance * material.roughness)
                            .cwiseMin(6.0f / exposure_);
  return diffuse * (1 - schlick) + schlick * seen;
}

cv::Mat RayTracer::Photograph(const PinholeCamera& camera,
                              std::span<const Eigen::Isometry3d> room_from_cam,
                              int samples_per_pixel, std::uint64_t seed, int frame) const {
  PLB_CHECK(!room_from_cam.empty() && samples_per_pixel > 0);
  std::vector<FloatPose> poses;
  for (const Eigen::Isometry3d& pose : room_from_cam) poses.push_back(ToFloat(pose));
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  const int columns = std::max(1, static_cast<int>(std::lround(std::sqrt(samples_per_pixel))));
  const int rows = (samples_per_pixel + columns - 1) / columns;
  const int samples = samples_per_pixel;
  cv::Mat image(camera.height, camera.width, CV_32FC3);
  tbb::parallel_for(
      tbb::blocked_range<int>(0, camera.height, 4), [&](const tbb::blocked_range<int>& range) {
        for (int y = range.begin(); y < range.end(); ++y) {
          auto* row = image.ptr<cv::Vec3f>(y);
          for (int x = 0; x < camera.width; ++x) {
            Random random({.seed = seed,
                           .frame = static_cast<std::uint32_t>(frame),
                           .object = static_cast<std::uint32_t>(y * camera.width + x),
                           .particle = 0x70686f});
            const auto draw = [&] { return static_cast<float>(random.Bits() >> 8) * 0x1.0p-24f; };
            const int shift = static_cast<int>(random.Index(static_cast<std::uint32_t>(samples)));
            Vector3f sum = Vector3f::Zero();
            for (int s = 0; s < samples; ++s) {
              const float u =
                  (static_cast<float>(s % columns) + draw()) / static_cast<float>(columns) - 0.5f;
              const float v =
                  (static_cast<float>(s / columns) + draw()) / static_cast<float>(rows) - 0.5f;
              const float time = (static_cast<float>((s + shift) % samples) + draw()) /
                                 static_cast<float>(samples);
              const FloatPose& pose =
                  poses[std::min(poses.size() - 1, static_cast<std::size_t>(
                                                       time * static_cast<float>(poses.size())))];
              const Vector3f in_cam((static_cast<float>(x) + u - cx) / fx,
                                    (static_cast<float>(y) + v - cy) / fy, 1);
              const Sample sample{draw(), 6.2831853f * draw()};
              const Vector3f seen =
                  Radiance(pose.origin, (pose.rotation * in_cam).normalized(), 1 / fx, sample);
              sum += seen.cwiseMin(
                  4.0f / exposure_);  // a highlight does not outshine its pixel's other samples
            }
            sum /= static_cast<float>(samples);
            row[x] = {sum.x(), sum.y(), sum.z()};
          }
        }
      });
  return image;
}

SurfaceMaps RayTracer::Look(const PinholeCamera& camera,
                            const Eigen::Isometry3d& room_from_cam) const {
  SurfaceMaps maps;
  maps.depth = cv::Mat(camera.height, camera.width, CV_32F, cv::Scalar(0));
  maps.instance = cv::Mat(camera.height, camera.width, CV_16U, cv::Scalar(0));
  maps.surface = cv::Mat(camera.height, camera.width, CV_32S, cv::Scalar(-1));
  maps.normal = cv::Mat(camera.height, camera.width, CV_32FC3, cv::Scalar::all(0));
  const FloatPose pose = ToFloat(room_from_cam);
  tbb::parallel_for(
      tbb::blocked_range<int>(0, camera.height, 8), [&](const tbb::blocked_range<int>& range) {
        for (int y = range.begin(); y < range.end(); ++y) {
          for (int x = 0; x < camera.width; ++x) {
            const Eigen::Vector2d bearing = camera.Bearing({x, y});
            const Vector3f in_cam(static_cast<float>(bearing.x()), static_cast<float>(bearing.y()),
                                  1);
            const float length = in_cam.norm();
            const TracedScene::Hit hit = scene_.Trace(pose.origin, pose.rotation * in_cam / length);
            if (!hit.valid()) continue;
            const TracedScene::Triangle& triangle = scene_.triangles()[hit.triangle];
            Vector3f normal = pose.rotation.transpose() * scene_.ShadingNormal(hit);
            if (normal.dot(in_cam) > 0) normal = -normal;
            maps.depth.at<float>(y, x) = hit.distance / length;
            maps.instance.at<std::uint16_t>(y, x) = triangle.instance;
            maps.surface.at<int>(y, x) = triangle.part;
            maps.normal.at<cv::Vec3f>(y, x) = {normal.x(), normal.y(), normal.z()};
          }
        }
      });
  return maps;
}

}  // namespace plumbline
