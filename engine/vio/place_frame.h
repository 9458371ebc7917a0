// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/features2d.hpp>

#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/distorted_camera.h"
#include "engine/vio/vio_filter.h"
#include "engine/vio/vio_report.h"

namespace plumbline {

/// A corner of a key frame's image.
struct PlaceCorner {
  Eigen::Vector2d pixel;       ///< As recorded.
  Eigen::Vector3d ray_in_cam;  ///< Unit.
  double size = 1;             ///< Of the patch that describes it, against the image's own scale.
};

/// An image to come back to: how its corners look, and where some of its points are.
struct PlaceFrame {
  int image = 0;  ///< Index in the source.
  std::int64_t stamp_ns = 0;
  int stretch = 0;
  Eigen::Isometry3d world_from_body = Eigen::Isometry3d::Identity();  ///< As the filter had it.
  /// In the order of PosePerturbation, of the body.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Isometry3d body_from_cam = Eigen::Isometry3d::Identity();

  std::vector<PlaceCorner> corners;
  cv::Mat descriptors;  ///< CV_8U, a row for each corner.

  std::vector<Eigen::Vector3d> points_in_body;
  cv::Mat point_descriptors;      ///< CV_8U; several rows for each point, one for each size.
  std::vector<int> point_of_row;  ///< Index into points_in_body.
  bool let_go = false;            ///< What it looked like is forgotten.

  std::size_t bytes() const;
  /// Nobody can come back to it any more; where it is stays known.
  void LetGo();
};

/// Makes key frames: ORB descriptors (Rublee et al., ICCV 2011; OpenCV's) of corners and of tracked
/// points, turned so that gravity is down in every patch. The depth of a tracked point comes when
/// the filter has finished with it. Single-threaded, deterministic.
class PlaceFrameMaker {
 public:
  PlaceFrameMaker(const Camera& camera, int corners);

  /// The key frame of an image: all but the points.
  /// @param picture  As recorded, CV_8UC1 or CV_8UC3.
  PlaceFrame Make(const cv::Mat& picture, const TrackedImage& tracked, int image,
                  const VioReport& report);

  /// Gives tracks of the newest key frames their places: those that the filter has finished, and
  /// those that are in its state. A track gets one place in each key frame, the first.
  /// @param key_frames  All so far.
  void AddPoints(std::span<const MapPoint> finished, std::span<PlaceFrame> key_frames);
  void AddStatePoints(const FilterState& state, std::span<PlaceFrame> key_frames);

  /// So many key frames were taken out that are older than the newest kWaitingKeyFrames.
  void Renumber(std::size_t gone);
  /// Depth that comes later than this many key frames was found from another place.
  static constexpr std::size_t kWaitingKeyFrames = 12;

 private:
  /// What a key frame's tracks look like, until their depth is known.
  struct Waiting {
    std::size_t key_frame = 0;
    std::map<std::int64_t, std::vector<cv::Mat>> rows;
  };
  static void Place(std::int64_t track, const Eigen::Vector3d& point_in_world, Waiting& waiting,
                    PlaceFrame& key_frame);
  double GravityAngleDeg(const Eigen::Vector3d& ray_in_cam,
                         const Eigen::Vector3d& down_in_cam) const;

  DistortedCamera camera_;
  cv::Ptr<cv::ORB> orb_;
  std::vector<Waiting> waiting_;
  std::size_t made_ = 0;
};

}  // namespace plumbline
