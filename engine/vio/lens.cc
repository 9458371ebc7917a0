// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/lens.h"

#include <algorithm>

#include "engine/sensor/distorted_camera.h"

namespace plumbline {

LensVector LensOf(const Camera& camera) {
  LensVector lens;
  lens << DistortedCamera(camera).intrinsics(), camera.rolling_shutter_s;
  return lens;
}

Camera WithLens(Camera camera, const LensVector& lens) {
  camera.pinhole.fx = lens[0];
  camera.pinhole.fy = lens[1];
  camera.pinhole.cx = lens[2];
  camera.pinhole.cy = lens[3];
  const auto count = std::min<std::ptrdiff_t>(4, std::ssize(camera.distortion));
  std::copy_n(lens.begin() + 4, count, camera.distortion.begin());
  camera.rolling_shutter_s = lens[kReadOut];
  return camera;
}

}  // namespace plumbline
