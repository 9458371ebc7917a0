// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "engine/dataset/reference_states.h"
#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"
#include "engine/vio/health_monitor.h"
#include "engine/vio/imu_buffer.h"
#include "engine/vio/rest_detector.h"
#include "engine/vio/stamp_watch.h"
#include "engine/vio/start_state.h"
#include "engine/vio/vio_filter.h"
#include "engine/vio/vio_options.h"
#include "engine/vio/vio_report.h"

namespace plumbline {

/// From an IMU's readings and tracked points to poses, from the first reading on: waits for a
/// start, filters, watches its health, and starts anew where the filter was lost. Single-threaded,
/// deterministic.
class VioEstimator {
 public:
  /// @param camera  With `body_from_cam`.
  VioEstimator(const Camera& camera, const ImuCalibration& imu, const VioOptions& options);

  /// Starts from this state at the first image that is not before it, instead of finding a start.
  void StartFrom(const ReferenceState& state) { given_ = state; }

  /// By rising stamp, up to ImuTimeOf() an image before that image. A clock that is set back is
  /// noticed after a few readings; the filter then starts anew.
  void AddImu(const ImuSample& sample);

  /// The next image. Nothing for one that is not used: it follows too fast, or its stamp does not
  /// rise (the next report says so, and where the camera's clock was set back). Several where a
  /// start in motion reaches back: first one of the waiting image, then those of the window.
  std::vector<VioReport> AddImage(const TrackedImage& image);

  /// The state carried to an image by the IMU alone: for images that follow too fast for the filter
  /// to use. Nothing unless the filter tracks.
  std::optional<FilterState> Predict(std::int64_t image_ns) const;

  /// Something that whoever feeds the estimator noticed; the next report says it.
  void Note(const std::string& sentence) { notes_ = WithNotes(sentence); }

  /// When an image was taken, on the IMU's clock as far as that is known.
  std::int64_t ImuTimeOf(std::int64_t image_ns) const;

  /// previous_from_present: how the gyro says that the camera turned between two images.
  Eigen::Matrix3d CamRotation(std::int64_t previous_ns, std::int64_t present_ns) const;

  /// Points that were finished since the last call.
  std::vector<MapPoint> TakePoints() { return filter_.TakePoints(); }
  const VioFilter& filter() const { return filter_; }

 private:
  bool TryGivenStart(const TrackedImage& image);
  /// @return what it waits for; "" when it started.
  std::string TryRestStart(const TrackedImage& image);
  std::string TryMotionStart();
  std::string TryStart(const TrackedImage& image);
  void Begin(InertialState inertial, StartSpread spread);
  void BeginWith(const FilterState& state);
  /// Moves a start to where the last stretch ended, with the uncertainty that the gap leaves.
  void JoinLastStretch(InertialState& inertial, StartSpread& spread) const;
  void ForgetOldReadings(std::int64_t image_ns);
  /// Gives the state up; waits for a start.
  void Restart();
  /// After points contradicted the IMU: whether another offset of the clocks explains it.
  void SeekClock(std::span<const TrackedImage> images);
  /// What the camera's clock moved by against the IMU's when they were set back.
  void MoveClock(std::int64_t later_ns, const char* whose);
  /// `message` after what was noted since the last report.
  std::string WithNotes(std::string message);
  VioReport Filter(const TrackedImage& image);
  VioReport Report(const TrackedImage& image, const FilterStep& step) const;

  Camera camera_;
  ImuCalibration calibration_;  ///< Its offset follows clocks that are set back.
  VioOptions options_;
  ImuBuffer imu_;
  RestDetector rest_;
  VioFilter filter_;
  HealthMonitor health_;
  std::optional<ReferenceState> given_;
  std::deque<TrackedImage> window_;  ///< Images of a start in motion.
  std::optional<std::int64_t> last_image_ns_, last_step_ns_, last_attempt_ns_;
  /// Where an earlier stretch ended, for the next to begin there.
  std::optional<VioReport> last_good_;
  StampWatch imu_clock_, image_clock_;
  double clock_shift_s_ = 0;  ///< In calibration_.time_offset_s, on top of what was given.
  int left_out_ = 0;          ///< Images since the last report whose stamps did not rise.
  bool clock_suspect_ = false;
  std::string notes_;
  bool tracking_ = false;
  int stretch_ = 0;
};

}  // namespace plumbline
