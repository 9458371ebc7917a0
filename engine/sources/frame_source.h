// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"
#include "engine/sensor/calibration.h"
#include "engine/sensor/imu.h"
#include "engine/sensor/pose_estimate.h"

namespace plumbline {

/// What was recorded with one image; a folder reads each part when it is asked for, a camera has
/// the image already. Functions are safe to call from several threads. Errors: kNotFound, kCorrupt,
/// naming the file: skip the frame and go on.
class FrameContent {
 public:
  virtual ~FrameContent() = default;
  virtual Result<cv::Mat> RawImage() const = 0;  ///< CV_8UC3 BGR as recorded: for tracking.
  virtual Result<cv::Mat> Image() const = 0;     ///< Undistorted into the pinhole camera.
  virtual Result<std::optional<EdgeMap>> Edges() const = 0;
  virtual Result<std::optional<std::vector<Detection>>> Proposals() const = 0;
  virtual Result<std::optional<cv::Mat>> Depth() const = 0;  ///< CV_16UC1 [mm].
};

struct FramePacket {
  int frame = 0;   ///< Counted from 0 by the source; rises, may have gaps.
  int camera = 0;  ///< Index in the source's calibration.
  std::int64_t stamp_ns = 0;
  std::shared_ptr<const FrameContent> content;
};

/// Which way is down, from now on.
struct GravityEstimate {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d gravity_in_world{0, 0, -1};  ///< Unit vector, down.
  int epoch = 0;                               ///< Of the world's poses that it belongs to.
};

/// Where the floor is, from now on.
struct FloorEstimate {
  std::int64_t stamp_ns = 0;
  /// (a, b, c, d) with (a, b, c) = up and a x + b y + c z + d = 0 on the floor.
  Eigen::Vector4d floor_in_world{0, 0, 1, 0};
  int epoch = 0;
  double std_m = 0;  ///< Of its height; 0: given, not estimated.
};

/// Points of the surfaces in sight that were found since the last of these.
struct PointEstimates {
  std::int64_t stamp_ns = 0;
  std::vector<Eigen::Vector3f> points_in_world;
  PoseEstimate seen_from;  ///< When that pose is corrected, they move with it.
};

using Packet = std::variant<GravityEstimate, FloorEstimate, PointEstimates, ImuSample, PoseEstimate,
                            FramePacket>;

/// Where images, IMU samples and poses come from: a recorded folder, later a camera or another
/// program. Packets come in the order of time; of those of one time, as `Packet` lists them, so
/// that a frame's pose comes before the frame. A pose of an id that was given before, with a higher
/// epoch, corrects it. What becomes of packets that nobody fetches in time is up to the source: a
/// recorded one waits.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const Calibration& calibration() const = 0;
  /// The next packet, waiting for it; nothing at the end of the stream. Call from one thread at a
  /// time. Errors: kCancelled once `stop` is requested; what ends the stream, in one sentence.
  virtual Result<std::optional<Packet>> Next(const std::stop_token& stop) = 0;
};

/// A source that can be asked for any of its frames. All but Next and Seek are safe to call from
/// several threads.
class RecordedSource : public FrameSource {
 public:
  virtual int num_frames() const = 0;
  virtual FramePacket Frame(int frame) const = 0;
  /// Nothing for a frame without a pose.
  virtual std::optional<PoseEstimate> Pose(int frame) const = 0;
  /// Next goes on with what follows the frame before: its IMU samples, its pose, then the frame.
  virtual void Seek(int frame) = 0;
};

}  // namespace plumbline
