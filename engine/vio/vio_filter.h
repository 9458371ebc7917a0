// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/distorted_camera.h"
#include "engine/sensor/imu.h"
#include "engine/vio/chi_square_gate.h"
#include "engine/vio/filter_state.h"
#include "engine/vio/imu_buffer.h"
#include "engine/vio/track_rows.h"
#include "engine/vio/track_table.h"
#include "engine/vio/triangulation.h"
#include "engine/vio/vio_options.h"
#include "engine/vio/vio_report.h"

namespace plumbline {

/// A point that the filter has finished with.
struct MapPoint {
  std::int64_t track = 0;
  Eigen::Vector3d point_in_world;
};

/// An error-state Kalman filter over the inertial state, the calibration, a window of past poses
/// and the longest tracks; other tracks are used when they end (MSCKF). The error is the invariant
/// one, so that what no measurement can tell (position and heading of the whole) stays untold:
/// docs/algorithms/vio.md. Single-threaded, deterministic.
class VioFilter {
 public:
  VioFilter(const Camera& camera, const ImuCalibration& imu, const VioOptions& options);

  /// Begins anew from this state.
  void Start(const FilterState& state);

  /// Carries the state to the image and updates it. The IMU must cover the image's time as far as
  /// it can. @param resting  The image shows what was seen half a second ago; its velocity may
  /// tell otherwise.
  FilterStep Step(const TrackedImage& image, const ImuBuffer& imu, bool resting);

  const FilterState& state() const { return state_; }
  const IntegrationNoise& noise() const { return noise_; }
  /// The present angular velocity of the body [rad/s].
  const Eigen::Vector3d& angular_velocity_in_body() const { return angular_velocity_; }
  /// Finished points since the last call, and none of those that are still in the state.
  std::vector<MapPoint> TakePoints() { return std::exchange(finished_, {}); }

 private:
  using Ended = std::map<std::int64_t, Track>;

  void Propagate(const TrackedImage& image, const ImuBuffer& imu, FilterStep& step);
  /// One pixel of a point of the state, in units of its noise.
  struct PointSight {
    std::int64_t track;
    Eigen::Vector2d pixel;
    int column;  ///< Of the point.
    Eigen::MatrixXd by_state;
    Eigen::Vector2d residual;
  };

  /// The camera and shutter that the state has now.
  void TakeLens();
  ColumnLayout Layout() const;
  /// What the picture moved by since the last image [px].
  double FlowOf(const TrackedImage& image);
  void UpdateWithPoints(const TrackedImage& image, FilterStep& step);
  std::optional<PointSight> SeePoint(const StatePoint& point, const Eigen::Vector2d& pixel,
                                     const ColumnLayout& layout, int column) const;
  static std::pair<Eigen::MatrixXd, Eigen::VectorXd> Stacked(std::span<const PointSight> sights);
  void UpdateWithSights(std::span<const PointSight> sights, const ColumnLayout& layout);
  /// Updates with what passes the gates. @return the tracks that do not.
  std::vector<std::int64_t> UpdateWithAgreeing(std::vector<PointSight> sights,
                                               const ColumnLayout& layout, FilterStep& step);
  const StatePoint* FindPoint(std::int64_t track) const;
  void UpdateWithTracks(const std::vector<std::pair<std::int64_t, Track>>& tracks,
                        FilterStep& step);
  void UpdateWithParts(const std::vector<SplitRows>& parts, const ColumnLayout& layout);
  void AddPoints(const std::vector<std::pair<std::int64_t, Track>>& tracks, FilterStep& step);
  bool MayBeAtRest() const;
  void UpdateAtRest();
  void UpdateTurnAtRest(FilterStep& step);
  void Marginalise(bool resting);
  void MoveAnchors(std::int64_t from_clone);
  std::vector<std::pair<std::int64_t, Track>> TakeEnded();
  /// Tracks that fill the window: those for the state, then those to be used up.
  void TakeFull(std::vector<std::pair<std::int64_t, Track>>& for_state,
                std::vector<std::pair<std::int64_t, Track>>& used_up);
  std::optional<TriangulatedPoint> TriangulateTrack(const Track& track) const;
  /// Whether the camera has surely moved from the track's first sight to its last.
  bool BaselineIsCertain(const Track& track) const;
  bool PassesGate(const Eigen::MatrixXd& jacobian, std::span<const RowRange> rows,
                  const Eigen::VectorXd& residual, FilterStep& step) const;
  /// The chi-squared gate by the state's share of the innovation's covariance; the statistics of
  /// `step` count it.
  bool CountInnovation(Eigen::MatrixXd innovation, const Eigen::VectorXd& residual,
                       FilterStep& step) const;

  DistortedCamera camera_;
  VioOptions options_;
  IntegrationNoise noise_;
  double jitter_rad_, creep_rad_;
  PixelModel pixels_;
  ChiSquareGate gate_;
  TriangulationOptions triangulation_;
  FilterState state_;
  TrackTable tracks_;
  std::map<std::int64_t, Eigen::Vector2d> last_pixels_;
  Eigen::Vector3d angular_velocity_{0, 0, 0};
  std::vector<MapPoint> finished_;
};

}  // namespace plumbline
