// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/folder_source.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine/base/check.h"

namespace plumbline {
namespace {

/// One frame of a sequence, read when asked for.
class FolderContent : public FrameContent {
 public:
  FolderContent(std::shared_ptr<const Sequence> sequence, int index)
      : sequence_(std::move(sequence)), index_(index) {}

  Result<cv::Mat> RawImage() const override { return sequence_->ReadRawImage(index_); }
  Result<cv::Mat> Image() const override {
    const Result<plumbline::Frame> frame = sequence_->ReadFrame(index_);
    if (!frame.ok()) return frame.error();
    return frame.value().image;
  }
  Result<std::optional<EdgeMap>> Edges() const override { return sequence_->ReadEdges(index_); }
  Result<std::optional<std::vector<Detection>>> Proposals() const override {
    return sequence_->ReadProposals(index_);
  }
  Result<std::optional<cv::Mat>> Depth() const override { return sequence_->ReadDepth(index_); }

 private:
  std::shared_ptr<const Sequence> sequence_;
  int index_;
};

}  // namespace

FolderSource::FolderSource(std::shared_ptr<const Sequence> sequence, bool with_imu)
    : sequence_(std::move(sequence)), with_imu_(with_imu) {}

const Calibration& FolderSource::calibration() const { return sequence_->calibration(); }
int FolderSource::num_frames() const { return sequence_->num_frames(); }

FramePacket FolderSource::Frame(int frame) const {
  return {frame, 0, sequence_->stamp_ns(frame),
          std::make_shared<const FolderContent>(sequence_, frame)};
}

std::optional<PoseEstimate> FolderSource::Pose(int frame) const {
  const auto world_from_cam = sequence_->world_from_cam(frame);
  if (!world_from_cam) return std::nullopt;
  PoseEstimate pose;
  pose.id = PoseId{frame};
  pose.stamp_ns = sequence_->stamp_ns(frame);
  pose.world_from_cam = *world_from_cam;
  pose.uncertainty = sequence_->pose_uncertainty(frame);
  return pose;
}

void FolderSource::Seek(int frame) {
  PLB_CHECK(frame >= 0 && frame <= num_frames()) << "frame " << frame << " of " << num_frames();
  frame_ = frame;
  ready_.clear();
  ended_ = false;
  sample_ = 0;
  if (!imu_ || frame == 0) return;
  const auto& samples = imu_->samples;
  const auto later = [](std::int64_t stamp, const ImuSample& s) { return stamp < s.stamp_ns; };
  const auto first =
      std::upper_bound(samples.begin(), samples.end(), sequence_->stamp_ns(frame - 1), later);
  sample_ = static_cast<std::size_t>(first - samples.begin());
}

void FolderSource::Refill(const std::stop_token& stop) {
  const bool last =
      growing_ != nullptr ? !growing_->WaitForFrame(frame_, stop) : frame_ >= num_frames();
  if (stop.stop_requested()) return;
  const std::int64_t until =
      last ? std::numeric_limits<std::int64_t>::max() : sequence_->stamp_ns(frame_);
  if (!told_world_) {
    told_world_ = true;
    std::int64_t first = until;
    if (!imu_->samples.empty()) first = std::min(first, imu_->samples.front().stamp_ns);
    if (const auto gravity = sequence_->gravity_in_world())
      ready_.emplace_back(GravityEstimate{first, *gravity});
    if (const auto floor = sequence_->floor_in_world())
      ready_.emplace_back(FloorEstimate{first, *floor});
  }
  for (; sample_ < imu_->samples.size() && imu_->samples[sample_].stamp_ns <= until; ++sample_)
    ready_.emplace_back(imu_->samples[sample_]);
  ended_ = last;
  if (last) return;
  if (const auto pose = Pose(frame_)) ready_.emplace_back(*pose);
  ready_.emplace_back(Frame(frame_++));
}

Result<std::optional<Packet>> FolderSource::Next(const std::stop_token& stop) {
  if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  if (!imu_) {
    Result<ImuRecording> imu = with_imu_ ? sequence_->ReadImu() : ImuRecording();
    if (!imu.ok()) return imu.error();
    imu_ = std::move(imu).value();
    Seek(frame_);
  }
  if (ready_.empty() && !ended_) Refill(stop);
  if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  if (ready_.empty()) return std::optional<Packet>();
  std::optional<Packet> packet = std::move(ready_.front());
  ready_.pop_front();
  return packet;
}

Status CheckHasPoses(const Sequence& sequence, const std::filesystem::path& poses) {
  if (NumPosedFrames(sequence) > 0) return {};
  if (!poses.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + poses.string() + "' has no pose within half a period of any frame of '" +
                     sequence.path().string() + "'; both must have the same clock"};
  }
  return Error{
      ErrorCode::kInvalidInput,
      "'" + sequence.path().string() +
          "' has no camera poses; find them from images and IMU with --poses vio, or give a "
          "trajectory with --poses FILE"};
}

}  // namespace plumbline
