// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/sensor/camera.h"
#include "engine/synthetic/light_map.h"
#include "engine/synthetic/room.h"
#include "engine/synthetic/shutter.h"
#include "engine/synthetic/traced_scene.h"

namespace plumbline {

/// What lies exactly at the pixel centres.
struct SurfaceMaps {
  cv::Mat depth;     ///< CV_32F, Z in cam (of the row) [m]; 0 for none
  cv::Mat instance;  ///< CV_16U, 0 for none
  cv::Mat surface;   ///< CV_32S, part of the room; -1 for none
  cv::Mat normal;    ///< CV_32FC3, of the shaded surface in cam, towards the camera
};

/// Takes pictures of a room. Immutable once built; uses all threads itself. What moves casts
/// shadows on what stands and shows in no reflection.
class RayTracer {
 public:
  ~RayTracer();
  /// Computes the light of the room. Errors: kCancelled.
  static Result<std::unique_ptr<const RayTracer>> Create(const Room& room,
                                                         const LightQuality& quality,
                                                         const WorkContext& context);

  /// Linear radiance as RGB, CV_32FC3, before any noise. Random numbers depend on (seed, frame,
  /// pixel) alone.
  cv::Mat Photograph(const PinholeCamera& camera, const Shutter& shutter, int samples_per_pixel,
                     std::uint64_t seed, int frame) const;

  /// Rays through the pixel centres, those of each row at the middle of its exposure.
  SurfaceMaps Look(const PinholeCamera& camera, const Shutter& shutter) const;

  /// Factor that brings the room's mean light to a fixed grey.
  float exposure() const { return exposure_; }
  /// Of what stands still.
  const TracedScene& scene() const { return scene_; }
  /// Colour of a point as a scanner would see it: pattern times light, linear RGB.
  Eigen::Vector3f ScannedColor(const TracedScene::Hit& hit, float footprint_m) const;

 private:
  explicit RayTracer(const Room& room);
  /// A part that moves: traced where it is at time 0, by rays that are moved back.
  struct MovingBody;
  /// What a ray meets first, and whose triangles `hit` counts; nullptr: what stands.
  struct Meeting {
    TracedScene::Hit hit;
    const MovingBody* body = nullptr;
  };
  struct Ray {
    Eigen::Vector3f origin, direction;
  };
  struct Gloss {
    bool traced;
    float weight, radius, angle;
  };
  struct FloatPose;
  struct Exposure;
  /// What moves, in place of what stands behind it at a time.
  Meeting Nearest(const Ray& ray, const TracedScene::Hit& still, double t_s) const;
  Eigen::Vector3f Shade(const Ray& ray, const Meeting& meeting, double t_s, float pixel_angle,
                        const Gloss& gloss) const;
  Eigen::Vector3f PixelRadiance(const Exposure& exposure, const std::vector<FloatPose>& poses,
                                int x, int y) const;
  Eigen::Vector3f Diffuse(const TracedScene& scene, const LightMap& light,
                          const TracedScene::Hit& hit, float footprint_m) const;
  /// The share of the light on a still point that what moves leaves it: of direct and other light.
  Eigen::Vector2f LeftByMoving(const Eigen::Vector3f& point, double t_s) const;
  Eigen::Vector3f Background(const Eigen::Vector3f& direction) const {
    return sky_ ? sky_->Radiance(direction) : Eigen::Vector3f::Zero();
  }

  TracedScene scene_;
  LightMap light_;
  std::vector<std::unique_ptr<const MovingBody>> moving_;
  std::optional<SunLight> sun_;
  std::optional<SkyLight> sky_;
  float exposure_ = 1;
};

}  // namespace plumbline
