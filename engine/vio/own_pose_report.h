// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the visual-inertial filter made of a whole sequence, image by image, as values: the run file
// keeps it, the mapper lives on it, the window draws it.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/options.h"
#include "engine/vio/loop_report.h"
#include "engine/vio/past_correction.h"
#include "engine/vio/vio_report.h"

namespace plumbline {

enum class TrackState : std::uint8_t {
  kFollowed,  ///< Seen, and not yet a point of the state.
  kInState,   ///< A point of the state; this image's sight of it was used.
  kRejected,  ///< A point of the state; the gate turned this image's sight away.
};
template <>
struct EnumNames<TrackState> {
  static constexpr std::string_view names[] = {"followed", "in the state", "rejected"};
};

/// A tracked point in one image.
struct TrackReport {
  std::int64_t id = 0;
  Eigen::Vector2f pixel{0, 0};  ///< In the undistorted image.
  int age = 0;                  ///< Images that it was seen in before this one.
  TrackState state = TrackState::kFollowed;
  float residual_px = 0;  ///< Of a point of the state: from where the filter expects it.
};

/// The floor, as far as it is known.
struct FloorReport {
  double height_m = 0;  ///< Along up, from the origin of `world`.
  double std_m = 0;
  int points = 0;  ///< That it was found from.
};

/// One image of the sequence.
struct OwnPoseReport {
  VioReport vio;
  bool measured = false;        ///< The filter used the image; otherwise its pose is a prediction.
  bool ready = false;           ///< The mapper may use the pose.
  std::string waits_for;        ///< Why it may not, a sentence; "" when it may.
  double tilt_std_rad = 0;      ///< Of gravity's direction.
  double velocity_std_m_s = 0;  ///< Of the worst axis.
  double nis_gate = 0;          ///< 95 % bound on the sum of the normalised innovations squared.
  double tracking_ms = 0;

  /// Of the camera; the covariance as sensor/pose_estimate.h has it. While the filter tracks.
  std::optional<Eigen::Isometry3d> world_from_cam;
  Eigen::Matrix<double, 6, 6> cam_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// What the IMU read at the time of the image, biases included.
  Eigen::Vector3d angular_velocity_rad_s{0, 0, 0}, specific_force_m_s2{0, 0, 0};

  std::vector<TrackReport> tracks;
  std::vector<Eigen::Vector3f> points_in_world;  ///< Finished since the image before.
  std::optional<FloorReport> floor;              ///< As known after this image.
};

/// Poses of a sequence from its own images and IMU. `world` has z up; it begins where the filter
/// began.
struct OwnPoses {
  std::vector<OwnPoseReport> frames;  ///< Index = frame of the sequence, up to the last asked for.
  LoopReport loops;                   ///< Places known again.
  /// Each pose is an estimate from nothing that came later; otherwise closed loops corrected all.
  bool causal = true;
  std::vector<PastCorrection> corrections;  ///< Of causal poses, by rising epoch.

  /// The floor as known in the end.
  std::optional<FloorReport> last_floor() const {
    return frames.empty() ? std::nullopt : frames.back().floor;
  }
  /// Where the camera is known to have been at a frame in the end: a map that was corrected on the
  /// way is in this world.
  std::optional<Eigen::Isometry3d> LastKnown(int frame) const {
    const auto at = static_cast<std::size_t>(frame);
    if (at >= frames.size() || !frames[at].ready) return std::nullopt;
    if (corrections.empty() || frame >= corrections.back().image ||
        corrections.back().past.empty() || !frames[at].world_from_cam)
      return frames[at].world_from_cam;
    return CorrectedBy(corrections.back(), corrections, WhenTold(frame));
  }
  /// Of a frame with a pose.
  PoseWhenTold WhenTold(int frame) const {
    const OwnPoseReport& report = frames[static_cast<std::size_t>(frame)];
    return {frame, report.vio.stamp_ns, *report.world_from_cam,
            report.vio.world_from_body.translation()};
  }
  /// Corrections that a frame's pose contains.
  int EpochAt(int frame) const { return causal ? loops.EpochAt(frame) : loops.epochs; }
};

/// What was found after what is known already.
struct OwnPoseGrowth {
  std::size_t first_image = 0;
  OwnPoses poses;  ///< Frames from `first_image` on and new corrections; with the loops of all.
  int images = 0;  ///< Looked at in all.
  bool ended = false;
};

}  // namespace plumbline
