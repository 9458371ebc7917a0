// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>

#include "engine/geometry/angles.h"
#include "engine/mapping/bytes.h"
#include "engine/mapping/mapper_options.h"

namespace plumbline {

/// How much of an independent look at the scene each frame adds, for what does not average over
/// time: whether an object is there. It grows with the motion of the camera since the last look
/// that counted, and, at rest, with time to at most one.
class NoveltyClock {
 public:
  /// In [0, 1]; sums to one while the camera moves by about the options' distances.
  double Advance(std::int64_t stamp_ns, const Eigen::Isometry3d& world_from_cam,
                 const MapperOptions& options) {
    if (!started_) {
      started_ = true;
      from_ = world_from_cam;
      from_ns_ = stamp_ns;
      credited_ = 1;
      return 1;
    }
    const double moved = std::hypot(
        (world_from_cam.translation() - from_.translation()).norm() / options.correlation_m,
        Eigen::AngleAxisd(world_from_cam.linear().transpose() * from_.linear()).angle() /
            (options.correlation_deg * kRadPerDeg));
    const double rested = static_cast<double>(stamp_ns - from_ns_) * 1e-9 / options.correlation_s;
    const double credit = 1 - std::exp(-moved - rested);
    const double gained = std::max(0.0, credit - credited_);
    credited_ = std::max(credited_, credit);
    if (moved > 1) {
      from_ = world_from_cam;
      from_ns_ = stamp_ns;
      credited_ = 0;
    }
    return gained;
  }
  void Save(ByteWriter& out) const {
    out.Put(started_);
    out.Put(from_);
    out.Put(from_ns_);
    out.Put(credited_);
  }
  void Restore(ByteReader& in) {
    started_ = in.Get<bool>();
    from_ = in.GetPose();
    from_ns_ = in.Get<std::int64_t>();
    credited_ = in.Get<double>();
  }

 private:
  bool started_ = false;
  Eigen::Isometry3d from_ = Eigen::Isometry3d::Identity();
  std::int64_t from_ns_ = 0;
  double credited_ = 0;
};

}  // namespace plumbline
