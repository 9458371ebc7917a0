// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the camera sits on the body, by how much the clocks differ, on request its lens, and
// whether the stated noise is right, from a recording: the filter runs over it forward and backward
// until both agree.

#include <span>
#include <vector>

#include "engine/base/result.h"
#include "engine/vio/imu_noise.h"
#include "engine/vio/vio_run.h"

namespace plumbline {

/// Camera rotation [rad], camera translation [m], time offset [s], then the lens (filter_state.h).
using RigVector = Eigen::Matrix<double, 7 + kLensSize, 1>;

/// What one image of a pass believed.
struct RigEstimate {
  double seconds = 0;  ///< Since the first image; falls in a pass that runs backward.
  Eigen::Isometry3d body_from_cam = Eigen::Isometry3d::Identity();
  double time_offset_s = 0;
  LensVector lens = LensVector::Zero();
  /// Standard deviations; of what is not estimated 0.
  RigVector spread = RigVector::Zero();
};

/// The filter over the whole recording, begun at what the pass before ended with.
struct RigPass {
  bool backward = false;
  std::vector<RigEstimate> estimates;  ///< Of images with a pose; the last is the result.
  double nis_per_dof = 0;              ///< 1 if the noise is as stated.
};

struct RigCalibration {
  std::vector<RigPass> passes;
  bool agreed = false;  ///< The last two passes lie within three standard deviations of each other.
  /// Their mean; its spread is what a pass believes, or half of what they differ by, if that is
  /// more.
  RigEstimate result;
  ImuNoise noise;  ///< Of the stillest second: at most that of the IMU.
};

/// Difference of two calibrations, in the order of RigEstimate::spread: b minus a, the rotation
/// about the axes of the body.
RigVector Difference(const RigEstimate& a, const RigEstimate& b);

/// The recording as a body would have made it that moved the same way in the opposite direction:
/// stamps t become C - t, angular velocities turn, specific forces stay; so do tracks, whose ids
/// are kept. The offset of the clocks and the read-out of a rolling shutter turn their signs.
struct ReversedRecording {
  VioInput input;
  std::vector<ImuSample> samples;  ///< What `input` refers to.
  std::vector<TrackedImage> images;
};
ReversedRecording Reverse(const VioInput& input, std::span<const TrackedImage> images);

/// @param images  Tracks by rising stamp.
/// @param options  What is estimated: the lens only where it says so. Its spreads of the given
/// calibration are those of the first pass and of every
///   later one: no pass is told what the one before has learned from the same images.
/// Errors: kDegenerate where the filter gets no pose; kCancelled.
Result<RigCalibration> CalibrateRig(const VioInput& input, std::span<const TrackedImage> images,
                                    const VioOptions& options, int most_passes,
                                    const WorkContext& work);

}  // namespace plumbline
