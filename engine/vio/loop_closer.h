// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/sensor/camera.h"
#include "engine/sensor/distorted_camera.h"
#include "engine/vio/chi_square_gate.h"
#include "engine/vio/loop_options.h"
#include "engine/vio/loop_report.h"
#include "engine/vio/place_frame.h"
#include "engine/vio/place_match.h"
#include "engine/vio/pose_graph.h"
#include "engine/vio/trajectory_correction.h"
#include "engine/vio/vio_run.h"

namespace plumbline {

/// What two key frames' relative pose drifted by (drift.h).
Eigen::Matrix4d DriftBetween(const PlaceFrame& from, const PlaceFrame& to, double factor);

/// Knows places again, image by image beside the filter, and keeps a pose graph of key frames that
/// says what the trajectory has to be corrected by. A place is believed where its points agree on a
/// pose, gravity is where it was, the pose is within what drift allows, and a second key frame says
/// the same. Single-threaded, deterministic.
class LoopCloser {
 public:
  /// @param camera  With `body_from_cam`.
  LoopCloser(const Camera& camera, const LoopOptions& options);

  /// The next image, in the order of time.
  void See(const VioMoment& moment);

  /// What is known of the trajectory now; of an image, later ones included.
  TrajectoryCorrection Correction() const;
  /// What the newest image's pose is to be corrected by, from nothing that came later.
  YawMove PresentMove() const;

  LoopReport Report() const;

 private:
  /// A loop that waits for another to say the same.
  struct Pending {
    GraphEdge edge;
    std::int64_t stamp_ns = 0;
    int inliers = 0;
    bool suspect = false;  ///< Farther off than drift by the graph's weights can be.
    Eigen::Vector4d says;  ///< The newest pose's error along `world`, order (x, y, z, yaw).
  };

  bool IsKeyFrame(const VioReport& report) const;
  void AddKeyFrame(PlaceFrame key_frame);
  double TurnBetween(std::size_t one, std::size_t other) const;      ///< Of what they look at.
  double DistanceBetween(std::size_t one, std::size_t other) const;  ///< [m]
  /// Of many key frames, lets go of those that are nearest to an older one.
  void KeepFew();
  void TakeOut(const std::vector<bool>& unwanted);
  /// Older key frames that may show the newest one's place, those with most points alike first.
  std::vector<std::pair<int, std::vector<PointMatch>>> Candidates() const;
  void Search();
  void Weigh(Pending loop);
  void Close(const std::vector<Pending>& loops);

  Camera camera_;
  DistortedCamera lens_;
  LoopOptions options_;
  ChiSquareGate gate_;
  PlaceFrameMaker maker_;
  std::vector<PlaceFrame> key_frames_;
  PoseGraph graph_;
  int num_kept_ = 0;  ///< Key frames that were not let go of.
  std::vector<Pending> pending_;
  std::int64_t last_closed_ns_ = 0;
  double pause_s_ = 0;  ///< After that.
  LoopReport report_;
};

}  // namespace plumbline
