// SPDX-License-Identifier: Apache-2.0
#pragma once

// What crosses to the window. Values only, shared and never written after publication. It includes
// mapping/map_report.h, which is values only too (a departure from the house rule: the alternative
// was to declare every field twice).

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/geometry/mesh.h"
#include "engine/mapping/map_report.h"
#include "engine/mapping/mapper_options.h"
#include "engine/snapshot/object_relation.h"
#include "engine/snapshot/run_history.h"

namespace plumbline {

/// One shape, as the window needs it.
struct ModelView {
  std::string name, category;
  std::shared_ptr<const TriangleMesh> mesh;
  Eigen::Vector3d center{0, 0, 0};
  bool any_azimuth = false;  ///< Looks the same from all sides.
  int symmetry_order = 1;    ///< Looks the same when turned by 360 degrees / this.
};

/// What does not change while a sequence plays.
struct SequenceView {
  std::string name, path;
  int num_frames = 0;
  double rate_hz = 30;
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
  };
  std::vector<Truth> truth;
};

/// Polyline of an object's mean outline in the image [px].
struct OutlineView {
  ObjectId object;
  std::vector<std::vector<Eigen::Vector2f>> contours;
};

/// One frame as the mapper left it: images are shared, not copied.
struct MapSnapshot {
  FrameReport report;
  cv::Mat image;                         ///< CV_8UC3 BGR
  cv::Mat edge_probability, edge_angle;  ///< CV_8U (see EdgeMap)
  cv::Mat depth;  ///< CV_32F Z-buffer of the mean states [m], 0 none; same aspect as the image,
                  ///< maybe half size
  cv::Mat id;     ///< CV_16U object id of the Z-buffer
  std::vector<OutlineView> outlines;
};

/// What is worked out of a frame besides what the mapper says, where somebody shows it.
struct FrameAnalysis {
  std::shared_ptr<const MapSnapshot> frame;  ///< Never null.
  /// How its objects stand to one another; nothing: nobody asked.
  std::optional<std::vector<ObjectRelation>> relations;
  ObjectId object;           ///< The one that is watched.
  std::vector<int> by_rank;  ///< Indices of its particles, the best first.
};

struct FrameEvent {
  int frame = 0;
  LifeEvent event;
};

enum class PlaybackState { kPaused, kPlaying, kFinished, kFailed };

struct PlaybackView {
  PlaybackState state = PlaybackState::kPaused;
  int frame = 0;                   ///< Shown now.
  int newest_mapped_frame = -1;    ///< The mapper has come this far.
  std::string message;             ///< Of a failure, or what it does now.
  double speed = 1;                ///< Factor on the rate of the sequence; 0: as fast as it goes.
  std::optional<int> seek_target;  ///< Mapping towards this frame.
  double frames_per_second =
      0;                  ///< Measured over the last frames that were shown; 0 while it rests.
  bool recorded = false;  ///< All frames come from a run file: nothing is mapped.
  /// Life events of all frames so far, by frame; never null.
  std::shared_ptr<const std::vector<FrameEvent>> events =
      std::make_shared<const std::vector<FrameEvent>>();
  /// Never null.
  std::shared_ptr<const RunHistory> history = std::make_shared<const RunHistory>();
  bool mapping = false;  ///< The mapper goes on, whatever is shown.
  bool follow = false;   ///< Shows every frame that is mapped; only while `mapping`.
  bool loop = false;     ///< Playing starts again at the end.
  /// Of the frame that is mapped next; null until the source is open.
  std::shared_ptr<const MapperOptions> options;
  /// That the shown frame was mapped with; null until there is one.
  std::shared_ptr<const MapperOptions> shown_options;
  std::uint64_t seed = 0;  ///< Of the run.
  std::string recording;   ///< The run file that holds the mapped frames; "": none.
  std::optional<int> range_begin, range_end;  ///< Frames that playing keeps to, both included.
};

}  // namespace plumbline
