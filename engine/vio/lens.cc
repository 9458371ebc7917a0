// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/lens.h"

#include <algorithm>

#include "engine/base/check.h"
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

LensEntry LensEntryOf(int row) {
  static constexpr LensEntry kEntries[kLensSize] = {{"fx", "fx_px", "px", 1, 2},
                                                    {"fy", "fy_px", "px", 1, 2},
                                                    {"cx", "cx_px", "px", 1, 2},
                                                    {"cy", "cy_px", "px", 1, 2},
                                                    {"distortion 1", "distortion_1", "", 1, 5},
                                                    {"distortion 2", "distortion_2", "", 1, 5},
                                                    {"distortion 3", "distortion_3", "", 1, 5},
                                                    {"distortion 4", "distortion_4", "", 1, 5},
                                                    {"read-out", "read_out_s", "ms", 1e3, 3}};
  PLB_CHECK(row >= 0 && row < kLensSize);
  return kEntries[row];
}

}  // namespace plumbline
