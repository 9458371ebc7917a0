// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/ray_tracer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/check.h"
#include "engine/base/random.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

/// Reflections weaker than this are left out.
constexpr float kFaintReflection = 0.045f;

/// Uniform numbers in [0, 1) with 16 random bits: enough for places in a pixel, and cheap.
class SmallDraws {
 public:
  explicit SmallDraws(const RandomKey& key) : random_(key) {}
  float Next() {
    if (left_ == 0) {
      bits_ = random_.Bits();
      left_ = 2;
    }
    const auto value = static_cast<float>(bits_ & 0xffff) * 0x1.0p-16f;
    bits_ >>= 16;
    --left_;
    return value;
  }

 private:
  Random random_;
  std::uint32_t bits_ = 0;
  int left_ = 0;
};

}  // namespace

struct RayTracer::FloatPose {
  explicit FloatPose(const Eigen::Isometry3d& pose)
      : rotation(pose.linear().cast<float>()), origin(pose.translation().cast<float>()) {}
  Eigen::Matrix3f rotation;
  Vector3f origin;
};

Result<std::unique_ptr<const RayTracer>> RayTracer::Create(const Room& room,
                                                           const LightQuality& quality,
                                                           const WorkContext& context) {
  std::unique_ptr<RayTracer> tracer(new RayTracer(room));
  Result<LightMap> light =
      LightMap::Compute(tracer->scene_, room.lights, room.sun, quality, context);
  if (!light) return light.error();
  tracer->light_ = std::move(*light);
  tracer->exposure_ = 0.62f / std::max(1e-6f, tracer->light_.MeanLuminance());
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

Vector3f RayTracer::Shade(const Ray& ray, const TracedScene::Hit& hit, float pixel_angle,
                          const Gloss& gloss) const {
  if (!hit.valid()) return Vector3f::Zero();
  const Material& material = scene_.material(scene_.triangles()[hit.triangle]);
  const Vector3f normal = scene_.ShadingNormal(hit);
  const float facing = std::abs(normal.dot(ray.direction));
  const float footprint = hit.distance * pixel_angle / std::sqrt(std::max(0.08f, facing));
  const Vector3f diffuse = Diffuse(hit, footprint);
  if (material.gloss <= 0) return diffuse;
  const float grazing = 1 - facing;
  // Schlick's approximation, held back at grazing angles: real surfaces are rough there.
  const float fresnel = material.gloss + 0.55f * (1 - material.gloss) * std::pow(grazing, 5.0f);
  if (fresnel < kFaintReflection) return diffuse;
  if (!gloss.traced) return diffuse * (1 - fresnel);
  Vector3f mirrored = ray.direction - 2 * normal.dot(ray.direction) * normal;
  const Vector3f side = mirrored.unitOrthogonal();
  const float radius = material.roughness * std::sqrt(gloss.radius);
  mirrored +=
      radius * (std::cos(gloss.angle) * side + std::sin(gloss.angle) * mirrored.cross(side));
  mirrored.normalize();
  const float below = mirrored.dot(normal);
  if (below < 0.01f) mirrored = (mirrored + (0.01f - below) * normal).normalized();
  const Vector3f point = ray.origin + hit.distance * ray.direction + 1e-3f * normal;
  const TracedScene::Hit reflected = scene_.Trace(point, mirrored);
  if (!reflected.valid()) return diffuse;
  // Bright windows would sparkle at few samples a pixel.
  const Vector3f seen = Diffuse(reflected, 0.02f + reflected.distance * material.roughness)
                            .cwiseMin(1.6f / exposure_);
  return diffuse * (1 - fresnel) + gloss.weight * fresnel * seen;
}

/// The samples of one picture: where in the pixel, when in the exposure.
struct RayTracer::Exposure {
  const PinholeCamera& camera;
  int samples, columns, rows;
  std::uint64_t seed;
  std::uint32_t frame;
};

Vector3f RayTracer::PixelRadiance(const Exposure& exposure, const std::vector<FloatPose>& poses,
                                  int x, int y) const {
  const PinholeCamera& camera = exposure.camera;
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  SmallDraws draws({.seed = exposure.seed,
                    .frame = exposure.frame,
                    .object = static_cast<std::uint32_t>(y * camera.width + x),
                    .particle = 0x70686f});
  const int samples = exposure.samples;
  const int shift = static_cast<int>(draws.Next() * static_cast<float>(samples));
  Vector3f sum = Vector3f::Zero();
  std::array<Vector3f, 4> origins, directions;
  for (int first = 0; first < samples; first += 4) {
    const int count = std::min(4, samples - first);
    for (int k = 0; k < 4; ++k) {
      const int s = first + std::min(k, count - 1);
      const float u = (static_cast<float>(s % exposure.columns) + draws.Next()) /
                          static_cast<float>(exposure.columns) -
                      0.5f;
      const float v = (static_cast<float>(s / exposure.columns) + draws.Next()) /
                          static_cast<float>(exposure.rows) -
                      0.5f;
      const float time =
          (static_cast<float>((s + shift) % samples) + draws.Next()) / static_cast<float>(samples);
      const FloatPose& pose =
          poses[static_cast<std::size_t>(time * static_cast<float>(poses.size()))];
      const Vector3f in_cam((static_cast<float>(x) + u - static_cast<float>(camera.cx)) / fx,
                            (static_cast<float>(y) + v - static_cast<float>(camera.cy)) / fy, 1);
      origins[static_cast<std::size_t>(k)] = pose.origin;
      directions[static_cast<std::size_t>(k)] = (pose.rotation * in_cam).normalized();
    }
    const auto hits = scene_.Trace4(origins, directions);
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(k);
      // Every other sample stands for two when it comes to reflections.
      const bool traced = samples == 1 || (first + k) % 2 == 0;
      const float weight =
          samples == 1 ? 1.0f : static_cast<float>(samples) / static_cast<float>((samples + 1) / 2);
      const Gloss gloss{traced, weight, draws.Next(), 6.2831853f * draws.Next()};
      // A highlight does not outshine the other samples of its pixel.
      sum += Shade({origins[i], directions[i]}, hits[i], 1 / fx, gloss).cwiseMin(4.0f / exposure_);
    }
  }
  return sum / static_cast<float>(samples);
}

cv::Mat RayTracer::Photograph(const PinholeCamera& camera, const Shutter& shutter,
                              int samples_per_pixel, std::uint64_t seed, int frame) const {
  PLB_CHECK(samples_per_pixel > 0);
  const int columns = std::max(1, static_cast<int>(std::lround(std::sqrt(samples_per_pixel))));
  const Exposure exposure{camera,  samples_per_pixel,
                          columns, (samples_per_pixel + columns - 1) / columns,
                          seed,    static_cast<std::uint32_t>(frame)};
  const auto poses_of = [&](int row) {
    const std::vector<Eigen::Isometry3d> poses = shutter.Exposure(row);
    return std::vector<FloatPose>(poses.begin(), poses.end());
  };
  const std::vector<FloatPose> of_first_row = poses_of(0);
  cv::Mat image(camera.height, camera.width, CV_32FC3);
  tbb::parallel_for(0, camera.height, [&](int y) {
    auto* row = image.ptr<cv::Vec3f>(y);
    const std::vector<FloatPose> poses = shutter.rolling() ? poses_of(y) : of_first_row;
    for (int x = 0; x < camera.width; ++x) {
      const Vector3f radiance = PixelRadiance(exposure, poses, x, y);
      row[x] = {radiance.x(), radiance.y(), radiance.z()};
    }
  });
  return image;
}

SurfaceMaps RayTracer::Look(const PinholeCamera& camera, const Shutter& shutter) const {
  SurfaceMaps maps;
  maps.depth = cv::Mat(camera.height, camera.width, CV_32F, cv::Scalar(0));
  maps.instance = cv::Mat(camera.height, camera.width, CV_16U, cv::Scalar(0));
  maps.surface = cv::Mat(camera.height, camera.width, CV_32S, cv::Scalar(-1));
  maps.normal = cv::Mat(camera.height, camera.width, CV_32FC3, cv::Scalar::all(0));
  tbb::parallel_for(0, camera.height, [&](int y) {
    const FloatPose pose(shutter.RoomFromCam(y));
    std::array<Vector3f, 4> origins, directions;
    origins.fill(pose.origin);
    for (int first = 0; first < camera.width; first += 4) {
      std::array<Vector3f, 4> in_cam;
      for (int k = 0; k < 4; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const Eigen::Vector2d bearing = camera.Bearing({first + k, y});
        in_cam[i] = {static_cast<float>(bearing.x()), static_cast<float>(bearing.y()), 1};
        directions[i] = pose.rotation * in_cam[i].normalized();
      }
      const auto hits = scene_.Trace4(origins, directions);
      for (int x = first; x < std::min(first + 4, camera.width); ++x) {
        const auto i = static_cast<std::size_t>(x - first);
        if (!hits[i].valid()) continue;
        const TracedScene::Triangle& triangle = scene_.triangles()[hits[i].triangle];
        Vector3f normal = pose.rotation.transpose() * scene_.ShadingNormal(hits[i]);
        if (normal.dot(in_cam[i]) > 0) normal = -normal;
        maps.depth.at<float>(y, x) = hits[i].distance / in_cam[i].norm();
        maps.instance.at<std::uint16_t>(y, x) = triangle.instance;
        maps.surface.at<int>(y, x) = triangle.part;
        maps.normal.at<cv::Vec3f>(y, x) = {normal.x(), normal.y(), normal.z()};
      }
    }
  });
  return maps;
}

}  // namespace plumbline
