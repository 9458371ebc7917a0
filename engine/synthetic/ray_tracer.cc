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

struct RayTracer::MovingBody {
  MovingBody(const RoomPart& moving, std::size_t index)
      : scene(std::span(&moving, 1)),
        part(static_cast<int>(index)),
        velocity_m_s(moving.velocity_m_s) {
    for (const Vector3f& vertex : scene.vertices()) bounds.extend(vertex);
  }
  Vector3f Moved(double t_s) const { return (t_s * velocity_m_s).cast<float>(); }
  /// Whether a ray may meet it, where it is at time 0.
  bool InReach(const Vector3f& origin, const Vector3f& direction) const {
    const Vector3f to_middle = bounds.center() - origin;
    const float along = std::max(0.0f, to_middle.dot(direction));
    const float radius = 0.5f * bounds.diagonal().norm();
    return (to_middle - along * direction).squaredNorm() < radius * radius;
  }

  TracedScene scene;
  LightMap light;
  int part;
  Eigen::Vector3d velocity_m_s;
  Eigen::AlignedBox3f bounds;
};

RayTracer::RayTracer(const Room& room) : scene_(StillParts(room)), sun_(room.sun), sky_(room.sky) {}

RayTracer::~RayTracer() = default;

Result<std::unique_ptr<const RayTracer>> RayTracer::Create(const Room& room,
                                                           const LightQuality& quality,
                                                           const WorkContext& context) {
  std::unique_ptr<RayTracer> tracer(new RayTracer(room));
  const LightSources sources{room.lights, room.sun, room.sky};
  Result<LightMap> light = LightMap::Compute(tracer->scene_, sources, quality, context);
  if (!light) return light.error();
  tracer->light_ = std::move(*light);
  for (std::size_t i = StillParts(room).size(); i < room.parts.size(); ++i) {
    auto body = std::make_unique<MovingBody>(room.parts[i], i);
    Result<LightMap> on_it = LightMap::Compute(body->scene, sources, quality, context);
    if (!on_it) return on_it.error();
    body->light = std::move(*on_it);
    tracer->moving_.push_back(std::move(body));
  }
  tracer->exposure_ = 0.62f / std::max(1e-6f, tracer->light_.MeanLuminance());
  return std::unique_ptr<const RayTracer>(std::move(tracer));
}

RayTracer::Meeting RayTracer::Nearest(const Ray& ray, const TracedScene::Hit& still,
                                      double t_s) const {
  Meeting meeting{still, nullptr};
  for (const auto& body : moving_) {
    const Vector3f origin = ray.origin - body->Moved(t_s);
    if (!body->InReach(origin, ray.direction)) continue;
    const TracedScene::Hit hit = body->scene.Trace(origin, ray.direction);
    if (!hit.valid() || (meeting.hit.valid() && meeting.hit.distance < hit.distance)) continue;
    meeting = {hit, body.get()};
  }
  return meeting;
}

Eigen::Vector2f RayTracer::LeftByMoving(const Vector3f& point, double t_s) const {
  constexpr float kCoverM = 1.5f;    ///< What lies nearer above takes light from the sky,
  constexpr float kCovered = 0.25f;  ///< down to this share.
  Eigen::Vector2f left(1, 1);
  for (const auto& body : moving_) {
    const Vector3f origin = point - body->Moved(t_s);
    if (sun_ && body->InReach(origin, sun_->to_sun) &&
        body->scene.Blocked(origin, sun_->to_sun, 100))
      left[0] = 0;
    const Vector3f up = Vector3f::UnitZ();
    if (body->InReach(origin, up) && body->scene.Blocked(origin, up, kCoverM)) left[1] = kCovered;
  }
  return left;
}

Vector3f RayTracer::Diffuse(const TracedScene& scene, const LightMap& light,
                            const TracedScene::Hit& hit, float footprint_m) const {
  const TracedScene::Triangle& triangle = scene.triangles()[hit.triangle];
  const Material& material = scene.material(triangle);
  const Vector3f color = PatternColor(material, scene.Texture(hit), footprint_m);
  if (triangle.lets_light_in) return color * material.emission;
  return color.cwiseProduct(light.At(hit) + Vector3f::Constant(material.emission));
}

Vector3f RayTracer::ScannedColor(const TracedScene::Hit& hit, float footprint_m) const {
  return Diffuse(scene_, light_, hit, footprint_m);
}

Vector3f RayTracer::Shade(const Ray& ray, const Meeting& meeting, double t_s, float pixel_angle,
                          const Gloss& gloss) const {
  const TracedScene::Hit& hit = meeting.hit;
  if (!hit.valid()) return Background(ray.direction);
  const TracedScene& scene = meeting.body != nullptr ? meeting.body->scene : scene_;
  const LightMap& light = meeting.body != nullptr ? meeting.body->light : light_;
  const Material& material = scene.material(scene.triangles()[hit.triangle]);
  const Vector3f normal = scene.ShadingNormal(hit);
  const float facing = std::abs(normal.dot(ray.direction));
  const float footprint = hit.distance * pixel_angle / std::sqrt(std::max(0.08f, facing));
  Vector3f diffuse = Diffuse(scene, light, hit, footprint);
  if (meeting.body == nullptr && !moving_.empty()) {
    const Vector3f point = ray.origin + hit.distance * ray.direction + 1e-3f * normal;
    const Eigen::Vector2f left = LeftByMoving(point, t_s);
    if (left.minCoeff() < 1) {
      const Vector3f all = light.At(hit), direct = light.DirectAt(hit).cwiseMin(all);
      diffuse.array() *=
          (left[0] * direct + left[1] * (all - direct)).array() / all.array().cwiseMax(1e-6f);
    }
  }
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
  if (!reflected.valid() && !sky_) return diffuse;
  // Bright windows would sparkle at few samples a pixel.
  const Vector3f seen =
      (reflected.valid()
           ? Diffuse(scene_, light_, reflected, 0.02f + reflected.distance * material.roughness)
           : Background(mirrored))
          .cwiseMin(1.6f / exposure_);
  return diffuse * (1 - fresnel) + gloss.weight * fresnel * seen;
}

/// The samples of one picture: where in the pixel, when in the exposure.
struct RayTracer::Exposure {
  const PinholeCamera& camera;
  int samples, columns, rows;
  std::uint64_t seed;
  std::uint32_t frame;
  const Shutter& shutter;
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
  std::array<double, 4> times_s{};
  const double middle_s = moving_.empty() ? 0 : exposure.shutter.TimeOf(y);
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
      times_s[static_cast<std::size_t>(k)] =
          middle_s + exposure.shutter.exposure_s() * (static_cast<double>(time) - 0.5);
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
      const Ray ray{origins[i], directions[i]};
      sum += Shade(ray, Nearest(ray, hits[i], times_s[i]), times_s[i], 1 / fx, gloss)
                 .cwiseMin(4.0f / exposure_);
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
                          seed,    static_cast<std::uint32_t>(frame),
                          shutter};
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
    const double t_s = shutter.TimeOf(y);
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
        const Meeting meeting = Nearest({origins[i], directions[i]}, hits[i], t_s);
        const TracedScene::Hit& hit = meeting.hit;
        if (!hit.valid()) continue;
        const TracedScene& scene = meeting.body != nullptr ? meeting.body->scene : scene_;
        const TracedScene::Triangle& triangle = scene.triangles()[hit.triangle];
        Vector3f normal = pose.rotation.transpose() * scene.ShadingNormal(hit);
        if (normal.dot(in_cam[i]) > 0) normal = -normal;
        maps.depth.at<float>(y, x) = hit.distance / in_cam[i].norm();
        maps.instance.at<std::uint16_t>(y, x) = triangle.instance;
        maps.surface.at<int>(y, x) = meeting.body != nullptr ? meeting.body->part : triangle.part;
        maps.normal.at<cv::Vec3f>(y, x) = {normal.x(), normal.y(), normal.z()};
      }
    }
  });
  return maps;
}

}  // namespace plumbline
