// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/reference_states.h"

#include <cmath>
#include <utility>

#include "engine/dataset/stamped_rows.h"
#include "engine/geometry/reach.h"

namespace plumbline {

Result<ReferenceStates> ReadReferenceStates(const std::filesystem::path& file) {
  constexpr double kUnitTolerance = 0.01;
  ReferenceStates result;
  int odd_poses = 0;
  auto warnings = ReadStampedRows(
      file, {"t,px,py,pz,qx,qy,qz,qw,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz", 16},
      [&](std::int64_t stamp_ns, std::span<const double> v) {
        const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
        if (!(std::abs(rotation.norm() - 1) < kUnitTolerance) || std::abs(v[0]) > kFarthest_m ||
            std::abs(v[1]) > kFarthest_m || std::abs(v[2]) > kFarthest_m) {
          ++odd_poses;
          return;
        }
        ReferenceState state;
        state.stamp_ns = stamp_ns;
        state.world_from_body.linear() = rotation.normalized().toRotationMatrix();
        state.world_from_body.translation() << v[0], v[1], v[2];
        state.velocity_in_world << v[7], v[8], v[9];
        state.gyro_bias << v[10], v[11], v[12];
        state.accel_bias << v[13], v[14], v[15];
        result.states.push_back(state);
      });
  if (!warnings.ok()) return warnings.error();
  result.warnings = std::move(warnings).value();
  if (odd_poses > 0) {
    result.warnings.push_back("'" + file.string() + "' has " + std::to_string(odd_poses) +
                              " rows whose quaternion is not of unit length or that are more "
                              "than 1000 km from the origin; left out");
  }
  if (result.states.empty())
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() +
                     "' holds no usable state; it needs rows "
                     "'t,px,py,pz,qx,qy,qz,qw,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz'"};
  MakeStampsRise(file, "states", result.states, result.warnings);
  return result;
}

}  // namespace plumbline
