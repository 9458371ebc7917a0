// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
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

/// Takes pictures of a room. Immutable once built; uses all threads itself.
class RayTracer {
 public:
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
  const TracedScene& scene() const { return scene_; }
  /// Colour of a point as a scanner would see it: pattern times light, linear RGB.
  Eigen::Vector3f ScannedColor(const TracedScene::Hit& hit, float footprint_m) const;

 private:
  explicit RayTracer(const Room& room) : scene_(room.parts) {}
  struct Ray {
    Eigen::Vector3f origin, direction;
  };
  struct Gloss {
    bool traced;
    float weight, radius, angle;
  };
  struct FloatPose;
  struct Exposure;
  Eigen::Vector3f Shade(const Ray& ray, const TracedScene::Hit& hit, float pixel_angle,
                        const Gloss& gloss) const;
  Eigen::Vector3f PixelRadiance(const Exposure& exposure, const std::vector<FloatPose>& poses,
                                int x, int y) const;
  Eigen::Vector3f Diffuse(const TracedScene::Hit& hit, float footprint_m) const;

  TracedScene scene_;
  LightMap light_;
  float exposure_ = 1;
};

}  // namespace plumbline
