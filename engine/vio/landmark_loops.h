// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/ids.h"
#include "engine/base/result.h"
#include "engine/sensor/pose_estimate.h"
#include "engine/vio/loop_options.h"
#include "engine/vio/pose_graph.h"
#include "engine/vio/trajectory_correction.h"

namespace plumbline {

/// What an object that was seen from two places says of them: it has not moved.
struct LandmarkEdge {
  ObjectId object;
  PoseId from, to;
  /// Of the cameras; only the turn about up and the way between them are taken from it.
  Eigen::Isometry3d from_cam_from_to_cam = Eigen::Isometry3d::Identity();
  /// Of `to` seen from `from`: (x, y, z [m], turn about z [rad]) along `world`.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
  double moved_m = 0;  ///< How far from where it was known the object was seen.
};

/// Of a run, by the frame in which they were seen.
using LandmarkHistory = std::map<int, std::vector<LandmarkEdge>>;

/// How a life event keeps them.
std::string LandmarkEdgesToText(std::span<const LandmarkEdge> edges);
/// Errors: kCorrupt.
Result<std::vector<LandmarkEdge>> LandmarkEdgesFromText(std::string_view text);
/// For people: "object 3 was seen 12 cm from where it stood".
std::string DescribeLandmarkEdges(std::span<const LandmarkEdge> edges);

/// Corrects poses, as they are told one by one, by objects that are seen again: a pose graph over
/// heading and position in which the poses' own drift ties one to the next. `world` has z up.
/// Single-threaded, deterministic: the same poses and edges in the same order give the same.
class LandmarkLoops {
 public:
  explicit LandmarkLoops(const LoopOptions& options);

  /// A pose as its source tells it; one with a known id replaces it. Ids rise with time.
  void See(const PoseEstimate& told);
  /// Objects seen again from the newest pose. Edges of poses that nobody told are left out.
  /// @return whether poses are corrected otherwise than before.
  bool Add(std::span<const LandmarkEdge> edges);
  /// After See() replaced poses: corrections anew.
  void Refresh();

  /// Any pose of the source as it is known when nothing came after it: moved by what was added up
  /// to then. Its epoch counts these corrections.
  PoseEstimate AtItsTime(const PoseEstimate& told) const;
  /// Any pose of the source as it is known now: Known() up to the last correction, and carried on
  /// from there.
  PoseEstimate Now(const PoseEstimate& told) const;
  /// All poses that were seen, as they are known now; with a higher epoch than they had.
  std::vector<PoseEstimate> Known() const;
  /// One of them; nothing where nobody told it.
  std::optional<PoseEstimate> Known(PoseId id) const;
  bool empty() const { return turns_.empty(); }

 private:
  /// What later poses are moved by from then on.
  struct Turn {
    PoseId after;
    Eigen::Isometry3d move = Eigen::Isometry3d::Identity();  ///< new_world_from_world
    PoseCovariance of_told = PoseCovariance::Zero(), corrected = PoseCovariance::Zero();
  };
  void Solve();

  LoopOptions options_;
  std::map<int, PoseEstimate> told_;  ///< By id.
  std::vector<LandmarkEdge> edges_;
  std::vector<Turn> turns_;
  TrajectoryCorrection correction_;
};

}  // namespace plumbline
