// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/own_pose_sequence.h"

#include <cmath>
#include <utility>
#include <vector>

#include "engine/base/check.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

Eigen::Vector4d PlaneOf(const FloorReport& floor) { return {0, 0, 1, -floor.height_m}; }

class OwnPoseSequence : public Sequence {
 public:
  OwnPoseSequence(std::shared_ptr<const Sequence> given, std::shared_ptr<const OwnPoses> poses)
      : given_(std::move(given)), poses_(std::move(poses)) {}

  const Sequence& given() const { return *given_; }
  const std::shared_ptr<const OwnPoses>& own_poses() const { return poses_; }

  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    PLB_CHECK(index >= 0 && index < num_frames()) << "frame " << index << " of " << num_frames();
    const auto at = static_cast<std::size_t>(index);
    if (at >= poses_->frames.size() || !poses_->frames[at].ready) return std::nullopt;
    return poses_->frames[at].world_from_cam;
  }
  PoseUncertainty pose_uncertainty(int index) const override {
    if (!world_from_cam(index)) return {};
    return {.drift = poses_->frames[static_cast<std::size_t>(index)].cam_covariance};
  }
  std::optional<Eigen::Vector3d> gravity_in_world() const override {
    return Eigen::Vector3d(0, 0, -1);
  }
  std::optional<Eigen::Vector4d> floor_in_world() const override {
    const auto floor = poses_->last_floor();
    return floor ? std::optional(PlaneOf(*floor)) : std::nullopt;
  }
  Result<Frame> ReadFrame(int index) const override {
    Result<Frame> frame = given_->ReadFrame(index);
    if (frame.ok()) frame->world_from_cam = world_from_cam(index);
    return frame;
  }

  const fs::path& path() const override { return given_->path(); }
  int num_frames() const override { return given_->num_frames(); }
  const PinholeCamera& camera() const override { return given_->camera(); }
  const Calibration& calibration() const override { return given_->calibration(); }
  double rate_hz() const override { return given_->rate_hz(); }
  std::int64_t stamp_ns(int index) const override { return given_->stamp_ns(index); }
  Result<cv::Mat> ReadRawImage(int index) const override { return given_->ReadRawImage(index); }
  Result<std::optional<cv::Mat>> ReadDepth(int index) const override {
    return given_->ReadDepth(index);
  }
  Result<std::optional<EdgeMap>> ReadEdges(int index) const override {
    return given_->ReadEdges(index);
  }
  Result<std::optional<std::vector<Detection>>> ReadProposals(int index) const override {
    return given_->ReadProposals(index);
  }
  Result<ImuRecording> ReadImu() const override { return given_->ReadImu(); }
  bool has_images() const override { return given_->has_images(); }
  bool has_imu() const override { return given_->has_imu(); }
  bool has_depth() const override { return given_->has_depth(); }
  bool has_edges() const override { return given_->has_edges(); }
  bool has_proposals() const override { return given_->has_proposals(); }
  std::optional<fs::path> scene_file() const override { return given_->scene_file(); }
  std::optional<fs::path> ground_truth_file() const override { return given_->ground_truth_file(); }
  std::optional<fs::path> models_folder() const override { return given_->models_folder(); }
  std::optional<fs::path> tracks_file() const override { return given_->tracks_file(); }
  std::optional<fs::path> reference_file() const override { return given_->reference_file(); }
  const std::vector<std::string>& warnings() const override { return given_->warnings(); }

 private:
  std::shared_ptr<const Sequence> given_;
  std::shared_ptr<const OwnPoses> poses_;
};

/// Whether a floor is worth telling again: clearly better known, or elsewhere.
bool Differs(const FloorReport& now, const std::optional<FloorReport>& told) {
  return !told || now.std_m < 0.8 * told->std_m ||
         std::abs(now.height_m - told->height_m) > 0.5 * told->std_m;
}

}  // namespace

std::shared_ptr<const Sequence> WithOwnPoses(std::shared_ptr<const Sequence> given,
                                             std::shared_ptr<const OwnPoses> poses) {
  return std::make_shared<const OwnPoseSequence>(std::move(given), std::move(poses));
}

std::shared_ptr<const OwnPoses> OwnPosesOf(const Sequence& sequence) {
  const auto* own = dynamic_cast<const OwnPoseSequence*>(&sequence);
  return own == nullptr ? nullptr : own->own_poses();
}

const Sequence& GivenSequence(const Sequence& sequence) {
  const auto* own = dynamic_cast<const OwnPoseSequence*>(&sequence);
  return own == nullptr ? sequence : own->given();
}

OwnPoseSource::OwnPoseSource(const std::shared_ptr<const Sequence>& sequence)
    : poses_(OwnPosesOf(*sequence)), folder_(sequence, false) {
  PLB_CHECK(poses_ != nullptr);
}

std::string OwnPoseSource::WaitsFor(int frame) const {
  const auto at = static_cast<std::size_t>(frame);
  return at < poses_->frames.size() ? poses_->frames[at].waits_for : std::string();
}

std::optional<PoseEstimate> OwnPoseSource::Pose(int frame) const {
  std::optional<PoseEstimate> pose = folder_.Pose(frame);
  if (pose) pose->epoch = poses_->EpochAt(frame);
  return pose;
}

void OwnPoseSource::Seek(int frame) {
  held_.clear();
  told_.reset();
  folder_.Seek(frame);
  // A floor is told as often as it would have been from the first frame on; points are told again,
  // and moved as often.
  std::optional<FloorReport> known;
  for (int i = 0; i < frame && i < static_cast<int>(poses_->frames.size()); ++i) {
    const OwnPoseReport& report = poses_->frames[static_cast<std::size_t>(i)];
    if (report.floor && Differs(*report.floor, known)) known = report.floor;
    TellCorrections(i);
    TellPoints(i);
  }
  const std::int64_t stamp_ns = frame > 0 ? folder_.Frame(frame - 1).stamp_ns : 0;
  if (known) {
    told_ = known;
    held_.push_back(FloorEstimate{stamp_ns, PlaneOf(*known), 0, known->std_m});
  }
}

void OwnPoseSource::TellCorrections(int frame) {
  for (const PastCorrection& correction : poses_->corrections) {
    if (correction.image != frame) continue;
    for (int i = 0; i < static_cast<int>(correction.world_from_cam.size()); ++i) {
      std::optional<PoseEstimate> pose = Pose(i);
      if (!pose) continue;
      pose->world_from_cam = correction.world_from_cam[static_cast<std::size_t>(i)];
      pose->epoch = correction.epoch;
      held_.push_back(*std::move(pose));
    }
  }
}

void OwnPoseSource::TellPoints(int frame) {
  const OwnPoseReport& report = poses_->frames[static_cast<std::size_t>(frame)];
  const std::optional<PoseEstimate> pose = Pose(frame);
  if (!report.ready || !pose || report.points_in_world.empty()) return;
  held_.push_back(PointEstimates{pose->stamp_ns, report.points_in_world, *pose});
}

Result<std::optional<Packet>> OwnPoseSource::Next(const std::stop_token& stop) {
  if (held_.empty()) {
    Result<std::optional<Packet>> packet = folder_.Next(stop);
    while (packet.ok() && *packet && std::holds_alternative<FloorEstimate>(**packet))
      packet = folder_.Next(stop);  // of the whole sequence: not known yet
    if (!packet.ok() || !*packet) return packet;
    if (auto* pose = std::get_if<PoseEstimate>(&**packet)) {
      *pose = *Pose(pose->id.value);
      TellCorrections(pose->id.value);
    }
    const auto* frame = std::get_if<FramePacket>(&**packet);
    if (frame != nullptr && frame->frame < static_cast<int>(poses_->frames.size())) {
      const OwnPoseReport& report = poses_->frames[static_cast<std::size_t>(frame->frame)];
      if (report.floor && Differs(*report.floor, told_)) {
        told_ = report.floor;
        held_.push_back(
            FloorEstimate{frame->stamp_ns, PlaneOf(*report.floor), 0, report.floor->std_m});
      }
      TellPoints(frame->frame);
    }
    held_.push_back(*std::move(packet).value());
  }
  Packet next = std::move(held_.front());
  held_.pop_front();
  return std::optional<Packet>(std::move(next));
}

LandmarkLoops ReplayLandmarks(const std::shared_ptr<const Sequence>& sequence,
                              const RunRecipe& recipe, int last_frame,
                              const LandmarkHistory& history) {
  const OwnPoseSource source(sequence);
  const OwnPoses& poses = *OwnPosesOf(*sequence);
  LandmarkLoops loops(recipe.own_poses.closing);
  std::size_t told = 0;  // corrections
  const int end = std::min(last_frame + 1, source.num_frames());
  for (int frame = recipe.frames.begin; frame < end; frame += recipe.frames.step) {
    for (; told < poses.corrections.size() && poses.corrections[told].image <= frame; ++told) {
      const PastCorrection& correction = poses.corrections[told];
      for (int i = 0; i < correction.image; ++i) {
        std::optional<PoseEstimate> pose = source.Pose(i);
        if (!pose) continue;
        pose->world_from_cam = correction.world_from_cam[static_cast<std::size_t>(i)];
        pose->epoch = correction.epoch;
        loops.See(*pose);
      }
      loops.Refresh();
    }
    if (const auto pose = source.Pose(frame)) loops.See(*pose);
    if (const auto seen = history.find(frame); seen != history.end()) loops.Add(seen->second);
  }
  return loops;
}

}  // namespace plumbline
