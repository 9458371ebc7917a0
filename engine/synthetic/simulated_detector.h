// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/dataset/sequence.h"
#include "engine/sensor/camera.h"
#include "engine/synthetic/ray_tracer.h"
#include "engine/synthetic/room.h"
#include "engine/synthetic/shutter.h"

namespace plumbline {

/// How a detector errs. Defaults are those of the ordinary room at 30 Hz.
struct DetectorFlaws {
  double missed = 0.20;  ///< Share of visible objects without a box; misses last a few frames.
  double false_per_frame = 0.5;  ///< Mean number of boxes on what is no object of that category.
  double box_noise = 0.05;    ///< Standard deviation of each side, as a share of width or height.
  double least_score = 0.35;  ///< Scores are drawn from here to .95.
  double split = 0.0;         ///< Share of the boxes that come as two halves.
  double doubled = 0.0;       ///< Share of the boxes that come twice.
  double miss_memory = 0.5;   ///< How much a miss depends on the frame before, 0 .. 1; the share of
                              ///< misses stays the same.
  double false_frames = 4;    ///< Mean number of frames that a false box lasts, >= 1.
  int min_pixels = 350;       ///< Objects showing less are not detected ...
  double min_visible =
      0.12;  ///< ... nor those of which less than this share shows within the image.
};

/// Of the scene's detector. Its misses and false boxes last about as long at any rate.
DetectorFlaws FlawsOf(const SyntheticOptions& options);

/// How much of each instance shows: entry i belongs to number i + 1 in the masks.
struct Visibility {
  std::vector<int> pixels;      ///< In the mask.
  std::vector<double> share;    ///< Of the whole projection within the image; 0 when all of it is
                                ///< hidden, -1 where nothing would show.
  std::vector<cv::Rect> box;    ///< Of the mask.
  std::vector<bool> truncated;  ///< The mask touches the border of the image.
};

/// Measures visibility by casting rays at each object alone, at a quarter of the size.
class VisibilityMeter {
 public:
  explicit VisibilityMeter(const Room& room);
  Visibility Measure(const PinholeCamera& camera, const Shutter& shutter,
                     const SurfaceMaps& maps) const;

 private:
  struct Body;
  std::vector<std::shared_ptr<const Body>> bodies_;
};

/// Boxes the visible parts of objects, with flaws. Frames are asked for in order, from 0.
class SimulatedDetector {
 public:
  SimulatedDetector(const Room& room, const DetectorFlaws& flaws, std::uint64_t seed);
  /// By falling score.
  std::vector<Detection> Detect(int frame, const PinholeCamera& camera, const Shutter& shutter,
                                const SurfaceMaps& maps, const Visibility& visibility);

 private:
  /// Something in the room that is taken for an object.
  struct Phantom {
    Eigen::Vector3d point_in_room;
    double width_m, height_m;
    std::string category;
    int last_frame;
  };
  void BoxObject(int frame, int instance, const PinholeCamera& camera, const Visibility& visibility,
                 std::vector<Detection>& found);
  void BoxPhantoms(int frame, const PinholeCamera& camera, const Shutter& shutter,
                   const SurfaceMaps& maps, std::vector<Detection>& found);

  std::vector<std::string> categories_;  ///< Of the instances.
  std::vector<std::string> known_;       ///< Categories without repetition.
  DetectorFlaws flaws_;
  std::uint64_t seed_;
  std::vector<bool> missing_;
  std::vector<Phantom> phantoms_;
};

}  // namespace plumbline
