// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is shown of a sequence and does not change from frame to frame.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/geometry/mesh.h"
#include "engine/smoothing/smoothed_map_report.h"
#include "engine/vio/own_pose_report.h"

namespace plumbline {

/// One shape, as the window needs it.
struct ModelView {
  std::string name, category;
  std::shared_ptr<const TriangleMesh> mesh;
  Eigen::Vector3d center{0, 0, 0};
  bool any_azimuth = false;         ///< Looks the same from all sides.
  int symmetry_order = 1;           ///< Looks the same when turned by 360 degrees / this.
  Eigen::AlignedBox3f bounds = {};  ///< In `object`; empty if not known.
};

/// What does not change while a sequence plays.
struct SequenceView {
  std::string name, path;
  int num_frames = 0;
  double rate_hz = 30;
  bool has_edges = false, has_proposals = false;  ///< Of its own.
  int image_width = 0, image_height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  Eigen::Vector3d up_in_world{0, 0, 1};
  std::optional<double> floor_height_m;           ///< Along up, where a floor is known.
  std::vector<ModelView> models;                  ///< Index = ModelId.
  std::vector<Eigen::Isometry3d> world_from_cam;  ///< Of every frame that has a pose, in order.
  /// The scanned scene made coarse enough to draw, and coarser for machines without a GPU; null
  /// without one.
  std::shared_ptr<const TriangleMesh> scan, scan_coarse;
  struct Truth {
    std::string id, model;
    Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
    double position_std_m = 0, azimuth_std_rad = 0;  ///< How well it is known.
    double scale = 1;                                ///< Times as large as its model.
  };
  std::vector<Truth> truth;

  /// What a second pass over the whole run has found; null for a run without one.
  std::shared_ptr<const SmoothedMap> smoothed;
  /// Of a run with poses = vio, else null. `world` is then the filter's.
  std::shared_ptr<const OwnPoses> own_poses;
  /// By frame: what these may still be off by after the alignment below, as they are told
  /// (sensor/pose_estimate.h); empty without it.
  std::vector<Eigen::Matrix<double, 6, 6>> aligned_pose_covariance;
  /// From the world of the poses, the scan and the truth that came with the sequence, by aligning
  /// the trajectories; all of these have been moved already.
  Eigen::Isometry3d world_from_given = Eigen::Isometry3d::Identity();
  /// By frame: the poses that came with the sequence; empty without any.
  std::vector<std::optional<Eigen::Isometry3d>> given_world_from_cam;
};

}  // namespace plumbline
