// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/dataset/imu_file.h"
#include "engine/dataset/sequence.h"
#include "engine/dataset/trajectory.h"
#include "engine/sensor/calibration.h"

namespace plumbline {

struct RecordedFrame {
  std::int64_t stamp_ns = 0;
  std::size_t item = 0;  ///< The reader's own number of it, which its functions get back.
  std::optional<Eigen::Isometry3d> world_from_cam;
};

/// What a reader of a data set has found while opening it, and how it gets at the rest. Its
/// functions are called from several threads.
struct Recording {
  std::filesystem::path path;
  Calibration calibration;
  std::vector<RecordedFrame> frames;
  std::optional<Eigen::Vector3d> gravity_in_world;  ///< Unit vector, down.
  /// Where a vehicle carries the camera: over the ground, which then follows from the path.
  std::optional<double> camera_height_m;
  std::vector<std::string> warnings;
  /// As Sequence::ReadRawImage.
  std::function<Result<cv::Mat>(std::size_t item)> read_image;
  /// CV_16UC1 [mm], of the size of the recorded image; nothing where this frame has none. Empty: no
  /// frame has.
  std::function<Result<std::optional<cv::Mat>>(std::size_t item)> read_depth;
  std::function<Result<ImuRecording>()> read_imu;  ///< Empty: there is no IMU.
  /// As Sequence::ReadProposals, in the recorded image. Empty: there are none.
  std::function<Result<std::optional<std::vector<Detection>>>(std::size_t item)> read_proposals;
  std::optional<std::filesystem::path> scene_file, models_folder;
};

/// The recording as a sequence: frames by strictly rising stamp, `options.poses` in place of its
/// poses. Errors: kCorrupt without frames; those of the trajectory.
Result<std::shared_ptr<const Sequence>> MakeSequence(Recording recording,
                                                     const SequenceOptions& options);

/// The pose at a time: between two that are at most `step_ns` apart, else that of the nearest at
/// most half of it away.
std::optional<Eigen::Isometry3d> PoseAt(const Trajectory& trajectory, std::int64_t stamp_ns,
                                        std::int64_t step_ns);

/// The pinhole camera. Errors: as CameraFromJson. `file` is only for messages.
Result<Camera> MakeCamera(const PinholeCamera& pinhole, double rate_hz,
                          const std::filesystem::path& file);

/// Depth of other units as CV_16UC1 [mm], 0 where there is none. What would exceed 65.5 m is none.
/// @param raw  CV_16UC1, 0 where there is none.
cv::Mat InMillimetres(const cv::Mat& raw, double units_per_metre);

/// The same of an image file. Errors: as ReadImage.
Result<cv::Mat> DepthFromFile(const std::filesystem::path& file, cv::Size size,
                              double units_per_metre);

/// Depth of one camera as another sees it from the same place: the nearest pixel's, 0 beyond.
cv::Mat SeenBy(const PinholeCamera& target, const PinholeCamera& source, const cv::Mat& depth);

/// Nanoseconds of the unit of rising stamps that name none: the first of ns, us, ms and s in which
/// the middle step between two lasts 2 ms to 5 s; 1 where none fits.
double NanosecondsPerUnit(const std::vector<std::uint64_t>& stamps);

bool IsThere(const std::filesystem::path& path);

/// The names of a folder in their order; none of a folder that cannot be read.
std::vector<std::string> NamesIn(const std::filesystem::path& folder);

/// The number in PREFIX + digits + ENDING.
std::optional<int> NumberInName(std::string_view name, std::string_view prefix,
                                std::string_view ending);

}  // namespace plumbline
