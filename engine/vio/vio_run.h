// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/progress.h"
#include "engine/dataset/reference_states.h"
#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"
#include "engine/tracking/tracker_options.h"
#include "engine/vio/vio_estimator.h"
#include "engine/vio/vio_options.h"
#include "engine/vio/vio_report.h"

namespace plumbline {

/// What a whole recording gave.
struct VioRun {
  std::vector<VioReport> reports;  ///< One for each image that was used.
  std::vector<MapPoint> points;
  std::vector<std::string> skipped;  ///< Images that could not be read, one sentence each.
  double tracking_ms = 0;            ///< Of all images; 0 with given tracks.
  int images = 0;                    ///< Looked at.
};

/// A recording.
struct VioInput {
  Camera camera;  ///< With `body_from_cam`.
  ImuCalibration imu;
  std::span<const ImuSample> samples;   ///< By rising stamp.
  std::optional<ReferenceState> start;  ///< Nothing: the estimator finds its own.
};

/// The recorded images of a camera, by rising stamp.
struct ImageSource {
  std::vector<std::int64_t> stamps_ns;
  /// As recorded, distortion included. An image that cannot be read is passed over.
  std::function<Result<cv::Mat>(int index)> read;
};

/// What one image did, for those who watch.
struct VioMoment {
  int image = 0;  ///< Index in the source.
  const cv::Mat& picture;
  const TrackedImage& tracked;
  std::span<const VioReport> reports;  ///< Of AddImage.
  std::span<const MapPoint> points;    ///< Finished since the image before.
  const VioEstimator& estimator;       ///< After the image.
  double tracking_ms = 0;
};
using VioObserver = std::function<void(const VioMoment&)>;

/// Runs the estimator over a recording in the order of time, on given tracks by rising stamp.
VioRun RunVio(const VioInput& input, std::span<const TrackedImage> images,
              const VioOptions& options, const WorkContext& work);

/// The same on images, whose points are tracked with the gyro's help, one at a time.
class VioRunner {
 public:
  /// @param input  Its samples outlive this.
  VioRunner(const VioInput& input, ImageSource images, const VioOptions& options,
            const TrackerOptions& tracker);
  ~VioRunner();

  /// Looks at the next image; false where there is none.
  bool Next(const VioObserver& seen = {});
  /// The recording has grown by an image. @param samples  Readings that there are now, those of
  /// before first; they outlive this. @param forgotten  How many of those of before, which were
  /// used, are gone.
  void Extend(std::int64_t stamp_ns, std::span<const ImuSample> samples, std::size_t forgotten);
  /// Of the readings that there are.
  std::size_t readings_used() const;
  /// On the IMU's clock, as far as its offset is known now [ns].
  std::int64_t ImuTimeOf(std::int64_t image_ns) const;
  /// Index of the image that Next looks at.
  int next() const;
  /// What it gave since this was asked last.
  VioRun TakeRun();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// All images of a source.
VioRun RunVio(const VioInput& input, const ImageSource& images, const VioOptions& options,
              const TrackerOptions& tracker, const WorkContext& work, const VioObserver& seen = {});

/// Leaves out tracks at random: each with this probability, for all its life.
std::vector<TrackedImage> DropTracks(std::span<const TrackedImage> images, double probability,
                                     std::uint64_t seed);

}  // namespace plumbline
