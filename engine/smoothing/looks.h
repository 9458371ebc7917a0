// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "engine/mapping/mapper_options.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// A frame that the run used.
struct PassedFrame {
  int frame = 0;
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
};

/// A frame that stands for the motion of the camera since the last one chosen.
struct Look {
  PassedFrame at;
  double steadiness = 1;  ///< 1 at rest, 1/2 where the image moves by a hundredth of its width a
                          ///< frame: fast motion blurs.
  double novelty = 0;     ///< How much of an independent look it is, in (0, 1].
  double dt_s = 0;        ///< Since the last one.
};

/// One frame, the steadiest, of every stretch that shows something new as the filter counts it
/// (NoveltyClock), in order.
std::vector<Look> ChooseLooks(std::span<const PassedFrame> frames, const PinholeCamera& camera,
                              const MapperOptions& options);

}  // namespace plumbline
