// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/random_access_file.h"
#include "engine/base/result.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// A .sens file of ScanNet, version 4: colour (JPEG or PNG), depth (16 bits, plain or zlib), poses.
/// Heads of frames are read when it is opened, pixels when they are asked for. Little-endian
/// (layout as of ScanNet/ScanNet, SensReader/python/SensorData.py). All functions are safe to call
/// from several threads.
class SensFile {
 public:
  struct Frame {
    std::optional<Eigen::Isometry3d> world_from_cam;  ///< None where tracking was lost (-inf).
    std::uint64_t color_stamp_us = 0;
    std::uint64_t color_begin = 0, color_size = 0, depth_begin = 0, depth_size = 0;
  };

  /// Errors: kNotFound, kIo, kCorrupt, kUnsupported (another version or compression).
  static Result<std::shared_ptr<const SensFile>> Open(const std::filesystem::path& file);
  SensFile(const SensFile&) = delete;
  SensFile& operator=(const SensFile&) = delete;

  const std::filesystem::path& path() const { return file_.path(); }
  const std::vector<Frame>& frames() const { return frames_; }
  const PinholeCamera& color_camera() const { return color_camera_; }
  const PinholeCamera& depth_camera() const { return depth_camera_; }
  /// Whether the two cameras are told to be at one place, as in all of ScanNet.
  bool same_place() const { return same_place_; }

  /// CV_8UC3 BGR. Errors: kIo, kCorrupt.
  Result<cv::Mat> ReadColor(std::size_t frame) const;
  /// CV_16UC1 [mm], of the depth camera; nothing where the frame has none. Errors: kIo, kCorrupt.
  Result<std::optional<cv::Mat>> ReadDepth(std::size_t frame) const;

 private:
  explicit SensFile(RandomAccessFile file) : file_(std::move(file)) {}
  Status ReadHeads();

  RandomAccessFile file_;
  PinholeCamera color_camera_, depth_camera_;
  bool same_place_ = true;
  int depth_compression_ = 0;
  double depth_units_per_metre_ = 1000;
  std::vector<Frame> frames_;
};

}  // namespace plumbline
