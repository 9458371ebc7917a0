// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "engine/sensor/distorted_camera.h"
#include "engine/vio/filter_state.h"
#include "engine/vio/point_view.h"
#include "engine/vio/track_table.h"

namespace plumbline {

/// Which rows of the error the columns of stacked Jacobians are: the camera on the body, the lens
/// where it is estimated, then the clones in their order, then points.
class ColumnLayout {
 public:
  /// @param lens  Whether the lens is estimated.
  ColumnLayout(const FilterState& state, bool lens);
  /// @return the point's first column.
  int AddPoint(const StatePoint& point);

  int camera() const { return 0; }
  bool has_lens() const { return has_lens_; }
  int lens() const { return kPoseSize; }  ///< First column, where it has any.
  int clone(std::int64_t id) const;       ///< First column.
  int size() const { return size_; }
  std::span<const RowRange> rows() const { return rows_; }

 private:
  std::vector<RowRange> rows_;
  std::vector<std::int64_t> clones_;
  bool has_lens_;
  int first_clone_column_, size_;
};

/// How pixels are measured.
struct PixelModel {
  double noise_px = 1;    ///< Of each sight by itself.
  double blur_noise = 0;  ///< Of what the picture moves by, on top.
  /// What a followed patch strays from one sight to the next, each axis: a random walk, which more
  /// sights do not average out.
  double creep_px = 0;
  double rolling_shutter_s = 0;  ///< From the first row to the last; the stamp is of the middle.
  double height_px = 1;

  /// Standard deviation of a pixel in the image of a clone.
  double NoiseIn(const PoseClone& clone) const {
    return std::hypot(noise_px, blur_noise * clone.flow_px);
  }
  /// Where the body was when this row was read.
  Eigen::Isometry3d WorldFromBody(const PoseClone& clone, double row_px) const {
    if (rolling_shutter_s == 0) return clone.world_from_body;
    return Moved(clone.world_from_body, rolling_shutter_s * MotionOfRow(clone, row_px));
  }
  /// The (phi, xi_p) of that pose by rolling_shutter_s.
  Eigen::Matrix<double, kPoseSize, 1> MotionOfRow(const PoseClone& clone, double row_px) const {
    return clone.motion * (row_px / (height_px - 1) - 0.5);
  }
};

/// How a sight moves with the lens.
Eigen::Matrix<double, 2, kLensSize> SightByLens(const DistortedCamera& camera,
                                                const PixelModel& pixels, const PointView& view,
                                                const PoseClone& clone, double row_px);

/// residual = by_state * error + by_point * error of the point + noise of unit variance.
struct TrackRows {
  Eigen::MatrixXd by_state;
  Eigen::MatrixXd by_point;  ///< 3 columns: the point in `world`.
  Eigen::VectorXd residual;
};

/// What the sights of a track say of a point, white whatever creeps; nothing where a camera cannot
/// see it.
/// @param used  Which of the observations count.
std::optional<TrackRows> RowsOfTrack(const DistortedCamera& camera, const FilterState& state,
                                     const ColumnLayout& layout,
                                     std::span<const Observation> observations,
                                     const std::vector<bool>& used,
                                     const Eigen::Vector3d& point_in_world,
                                     const PixelModel& pixels);

/// The rows turned so that the first three alone speak of the point, upper triangular, and the
/// others are free of it: the left null space of `by_point` (Mourikis and Roumeliotis, ICRA 2007).
struct SplitRows {
  Eigen::MatrixXd point_by_state;  ///< 3 rows
  Eigen::Matrix3d by_point;
  Eigen::Vector3d point_residual;
  Eigen::MatrixXd by_state;
  Eigen::VectorXd residual;
};
SplitRows SplitOffPoint(const TrackRows& rows);

/// The same information in at most as many rows as columns (QR).
void Compress(Eigen::MatrixXd& jacobian, Eigen::VectorXd& residual);

}  // namespace plumbline
