// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/worker.h"
#include "engine/mapping/mapper.h"
#include "engine/pipeline/corrected_poses.h"
#include "engine/sources/frame_source.h"
#include "engine/vision/detector.h"
#include "engine/vision/edge_detector.h"

namespace plumbline {

/// A frame made ready for the mapper, or why it cannot be used.
struct Prepared {
  Frame frame;
  EdgeMap edges;
  std::optional<MapperInput> input;
  int options_version = 0;             ///< Of the options that the table was made with.
  std::optional<FloorEstimate> floor;  ///< As known at the frame.
  PoseNews news;                       ///< Since the frame before.
  std::string skipped;
  SkipCause skip_cause = SkipCause::kUnknown;  ///< What was prepared last.
  std::vector<StageTiming> timings;
};

/// Finds edges and detections of frames, at the same time. Used by one thread at a time.
class FramePreparer {
 public:
  FramePreparer(std::unique_ptr<Detector> detector, std::unique_ptr<EdgeDetector> edges,
                const MapperOptions& options, double focal_px);

  void SetOptions(const MapperOptions& options) {
    options_ = options;
    ++options_version_;
  }
  int options_version() const { return options_version_; }

  /// @param pose  Of the frame; nothing where it has none.
  /// @param why_not  Why it has none, where that is known.
  Prepared Prepare(const FramePacket& packet, const std::optional<PoseEstimate>& pose,
                   const std::string& why_not);

 private:
  Status TryPrepare(const FramePacket& packet, const std::optional<PoseEstimate>& pose,
                    const std::string& why_not, Prepared& prepared);

  std::unique_ptr<Detector> detector_;
  std::unique_ptr<EdgeDetector> edges_;
  MapperOptions options_;
  double focal_px_;
  int options_version_ = 0;
  Worker detecting_;  ///< Last: ends before what it uses.
};

}  // namespace plumbline
