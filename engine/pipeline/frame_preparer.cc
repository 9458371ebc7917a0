// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/frame_preparer.h"

#include <utility>

#include "engine/base/timer.h"

namespace plumbline {
namespace {

/// What a network made of a frame, and how long it took.
template <typename Output>
struct Timed {
  Result<Output> output;
  double ms = 0;
};

template <typename Network>
auto TimedDetect(Network& network, const Frame& frame) {
  const Stopwatch watch;
  auto output = network.Detect(frame);
  return Timed<std::decay_t<decltype(*output)>>{std::move(output), watch.Milliseconds()};
}

}  // namespace

FramePreparer::FramePreparer(std::unique_ptr<Detector> detector,
                             std::unique_ptr<EdgeDetector> edges, const MapperOptions& options,
                             double focal_px)
    : detector_(std::move(detector)),
      edges_(std::move(edges)),
      options_(options),
      focal_px_(focal_px) {}

Prepared FramePreparer::Prepare(const FramePacket& packet, const std::optional<PoseEstimate>& pose,
                                const std::string& why_not) {
  Prepared prepared;
  prepared.options_version = options_version_;
  prepared.frame.index = packet.frame;
  prepared.frame.stamp_ns = packet.stamp_ns;
  const Status status = TryPrepare(packet, pose, why_not, prepared);
  if (!status.ok()) {
    prepared.skipped = status.error().message;
    prepared.input.reset();
  }
  return prepared;
}

Status FramePreparer::TryPrepare(const FramePacket& packet, const std::optional<PoseEstimate>& pose,
                                 const std::string& why_not, Prepared& prepared) {
  Stopwatch watch;
  prepared.skip_cause = SkipCause::kImage;
  Result<cv::Mat> image = packet.content->Image();
  if (!image.ok()) return image.error();
  prepared.frame.image = std::move(image).value();
  if (pose) prepared.frame.world_from_cam = pose->world_from_cam;
  prepared.timings.push_back({"decode", watch.Lap()});
  prepared.skip_cause = SkipCause::kPose;
  if (!pose) {
    return Error{ErrorCode::kNotFound, "frame " + std::to_string(packet.frame) +
                                           " has no camera pose" +
                                           (why_not.empty() ? "" : ": " + why_not)};
  }
  auto detecting =
      detecting_.Do([this, frame = prepared.frame] { return TimedDetect(*detector_, frame); });
  auto edges = TimedDetect(*edges_, prepared.frame);
  auto detections = detecting.get();
  prepared.skip_cause = SkipCause::kEdges;
  if (!edges.output.ok()) return edges.output.error();
  prepared.edges = std::move(edges.output).value();
  prepared.timings.push_back({"edges", edges.ms});
  prepared.skip_cause = SkipCause::kDetections;
  if (!detections.output.ok()) return detections.output.error();
  prepared.timings.push_back({"detect", detections.ms});
  watch.Lap();
  MapperInput input;
  input.frame = packet.frame;
  input.stamp_ns = packet.stamp_ns;
  input.world_from_cam = pose->world_from_cam;
  input.pose_uncertainty = pose->uncertainty;
  input.pose_id = pose->id;
  input.pose_epoch = pose->epoch;
  input.image = prepared.frame.image;
  input.edges = prepared.edges;
  MakeTables(options_, focal_px_, input);
  input.detections = std::move(detections.output).value();
  prepared.input = std::move(input);
  prepared.timings.push_back({"search table", watch.Lap()});
  return {};
}

}  // namespace plumbline
