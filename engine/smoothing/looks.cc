// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/looks.h"

#include <algorithm>

#include "engine/mapping/novelty_clock.h"

namespace plumbline {
namespace {

constexpr double kLeastNovelty = 0.8;
constexpr double kUsualDepth_m = 2;  ///< Of what moves in the image when the camera does.
constexpr double kFastImage = 0.01;  ///< Of its width, per frame.

/// By how much the image moves between two frames that follow one another [widths].
double ImageMotion(const PassedFrame& a, const PassedFrame& b, const PinholeCamera& camera) {
  const Eigen::Isometry3d a_from_b = a.world_from_cam.inverse() * b.world_from_cam;
  const double angle =
      Eigen::AngleAxisd(a_from_b.linear()).angle() + a_from_b.translation().norm() / kUsualDepth_m;
  return angle * camera.fx / camera.width / std::max(1, b.frame - a.frame);
}

}  // namespace

std::vector<Look> ChooseLooks(std::span<const PassedFrame> frames, const PinholeCamera& camera,
                              const MapperOptions& options) {
  std::vector<Look> looks;
  NoveltyClock clock;
  double gained = 0;
  std::int64_t last_ns = frames.empty() ? 0 : frames.front().stamp_ns;
  Look steadiest{{}, 0, 0, 0};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double motion = frames.size() < 2 ? 0
                          : i == 0          ? ImageMotion(frames[0], frames[1], camera)
                                            : ImageMotion(frames[i - 1], frames[i], camera);
    const double steadiness = 1 / (1 + motion / kFastImage);
    if (steadiness > steadiest.steadiness) steadiest = {frames[i], steadiness, 0, 0};
    gained += clock.Advance(frames[i].stamp_ns, frames[i].world_from_cam, options);
    if (gained < kLeastNovelty) continue;
    steadiest.novelty = std::min(1.0, gained);
    steadiest.dt_s = static_cast<double>(steadiest.at.stamp_ns - last_ns) * 1e-9;
    last_ns = steadiest.at.stamp_ns;
    looks.push_back(steadiest);
    steadiest = {{}, 0, 0, 0};
    gained = 0;
  }
  return looks;
}

}  // namespace plumbline
