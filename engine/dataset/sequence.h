// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/dataset/imu_file.h"
#include "engine/geometry/box.h"
#include "engine/geometry/floor_level.h"
#include "engine/sensor/calibration.h"
#include "engine/sensor/pose_estimate.h"

namespace plumbline {

/// A box that a detector proposes: COCO category name and score in [0, 1].
struct Detection {
  Box2 box;
  std::string category;
  float score = 0;
};

/// Thinned edges of one image, same size as the image.
struct EdgeMap {
  cv::Mat
      probability;  ///< CV_8U, 255 = certain, 0 = no edge; thinned to one-pixel lines; calibrated.
  cv::Mat angle;    ///< CV_8U, direction of the edge NORMAL in [0, pi), times 256 / pi.

  bool empty() const { return probability.empty(); }
};

/// One image and what was recorded with it.
struct Frame {
  int index = 0;  ///< Position in the sequence.
  std::int64_t stamp_ns = 0;
  cv::Mat image;  ///< CV_8UC3 BGR, undistorted into `Sequence::camera()`.
  std::optional<Eigen::Isometry3d> world_from_cam;
};

/// A recorded sequence: frames in time order with random access by index. Images are decoded when
/// asked for. All functions are safe to call from several threads. Frames that cannot be used are
/// errors of ReadFrame; the sequence itself opens as long as its camera and its list of frames make
/// sense.
class Sequence {
 public:
  virtual ~Sequence() = default;

  virtual const std::filesystem::path& path() const = 0;
  virtual int num_frames() const = 0;
  /// The pinhole camera of the undistorted images.
  virtual const PinholeCamera& camera() const = 0;
  /// The sensors that recorded: cameras of the images as recorded, and the IMU if there is one.
  virtual const Calibration& calibration() const = 0;
  virtual double rate_hz() const = 0;
  virtual std::int64_t stamp_ns(int index) const = 0;
  virtual std::optional<Eigen::Isometry3d> world_from_cam(int index) const = 0;
  /// Of that pose; zero where nothing is told.
  virtual PoseUncertainty pose_uncertainty(int) const { return {}; }
  /// Unit vector pointing down.
  virtual std::optional<Eigen::Vector3d> gravity_in_world() const = 0;
  /// (a, b, c, d) with (a, b, c) = up and a x + b y + c z + d = 0 on the floor.
  virtual std::optional<Eigen::Vector4d> floor_in_world() const = 0;
  /// Of that floor's height [m]; 0: it is given.
  virtual double floor_std_m() const { return 0; }
  /// Beside that floor; none without it.
  virtual std::vector<FloorLevel> floor_levels() const { return {}; }

  /// Errors: kNotFound, kCorrupt (naming the image file): skip the frame and go on. Of a sequence
  /// without images every frame is kNotFound.
  virtual Result<Frame> ReadFrame(int index) const = 0;
  /// The image as recorded, distortion included: CV_8UC3 BGR. Errors: as ReadFrame.
  virtual Result<cv::Mat> ReadRawImage(int index) const = 0;
  /// CV_16UC1 [mm], 0 where there is none, undistorted as the image; nothing where the sequence has
  /// no depth for this frame. Errors: kCorrupt.
  virtual Result<std::optional<cv::Mat>> ReadDepth(int index) const = 0;
  /// Precomputed edges; nothing where the sequence has none. Errors: kCorrupt.
  virtual Result<std::optional<EdgeMap>> ReadEdges(int index) const = 0;
  /// Precomputed proposals; nothing where the sequence has none. Errors: kCorrupt.
  virtual Result<std::optional<std::vector<Detection>>> ReadProposals(int index) const = 0;
  /// Everything that the IMU measured, read when asked for; empty where there is no IMU. Errors:
  /// kCorrupt.
  virtual Result<ImuRecording> ReadImu() const = 0;
  virtual bool has_images() const = 0;
  virtual bool has_imu() const = 0;
  virtual bool has_depth() const = 0;
  virtual bool has_edges() const = 0;
  virtual bool has_proposals() const = 0;

  /// Optional companions; nothing where the sequence has none.
  virtual std::optional<std::filesystem::path> scene_file() const = 0;
  virtual std::optional<std::filesystem::path> ground_truth_file() const = 0;
  virtual std::optional<std::filesystem::path> models_folder() const = 0;
  virtual std::optional<std::filesystem::path> tracks_file() const = 0;     ///< ReadTracksFile
  virtual std::optional<std::filesystem::path> reference_file() const = 0;  ///< ReadReferenceStates

  /// What was odd while opening (a pose that is not finite, an unordered stamp ...), one sentence
  /// each.
  virtual const std::vector<std::string>& warnings() const = 0;
};

struct SequenceOptions {
  /// A TUM trajectory to use instead of the poses of the data set; empty: those of the data set. It
  /// must be in the world that the sequence's gravity belongs to. Joined by stamp, within half a
  /// period.
  std::filesystem::path poses;
};

/// Opens any sequence that a reader of sequence_formats.h knows. Errors: kNotFound, kCorrupt,
/// kInvalidInput, kUnsupported; one sentence that names the file.
Result<std::shared_ptr<const Sequence>> OpenSequence(const std::filesystem::path& path,
                                                     const SequenceOptions& options = {});

/// How many of its frames have a pose.
int NumPosedFrames(const Sequence& sequence);

}  // namespace plumbline
