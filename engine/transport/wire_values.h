// SPDX-License-Identifier: Apache-2.0
#pragma once

// The values of the engine as messages have them, and back. What comes back is checked: nobody
// vouches for a message.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"
#include "engine/sensor/pose_estimate.h"
#include "engine/transport/plumbline.pb.h"
#include "engine/transport/shared_image.h"

namespace plumbline {

/// What sending images has cost a program. Safe to use from several threads.
struct PixelCounts {
  std::atomic<std::uint64_t> shared{0}, sent{0}, copied_bytes{0};
};

/// An image of 8 bits that may be sent to several peers, each in the way that suits it; every form
/// is made once, when it is asked for first. Safe to use from several threads.
class SendablePixels {
 public:
  explicit SendablePixels(cv::Mat image, std::shared_ptr<PixelCounts> counts)
      : image_(std::move(image)), counts_(std::move(counts)) {}

  /// For who sent `request`: shared memory on this machine, else compressed without loss, or plain
  /// where it asks for that.
  Result<wire::Pixels> For(const wire::Request& request);

 private:
  const cv::Mat image_;
  const std::shared_ptr<PixelCounts> counts_;
  std::mutex mutex_;
  std::shared_ptr<const SharedImage> shared_;
  std::string png_;
};

/// Errors: kNotFound for shared memory that is gone; kCorrupt.
Result<cv::Mat> PixelsFromWire(const wire::Pixels& pixels);

void SetTransform(const Eigen::Isometry3d& transform,
                  google::protobuf::RepeatedField<double>& rows);
/// Errors: kCorrupt for other than twelve finite numbers.
Result<Eigen::Isometry3d> TransformFromWire(const google::protobuf::RepeatedField<double>& rows);

wire::Sequence SequenceToWire(const Sequence& sequence);

wire::Proposals ProposalsToWire(std::span<const Detection> detections);
/// Errors: kCorrupt for boxes and scores that are no numbers, scores outside [0, 1].
Result<std::vector<Detection>> ProposalsFromWire(const wire::Proposals& proposals);

}  // namespace plumbline
