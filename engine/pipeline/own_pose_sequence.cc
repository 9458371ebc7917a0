// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/own_pose_sequence.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/base/check.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

/// The filter looks at so many images more than were asked for: it is a module of its own.
constexpr int kImagesAhead = 16;

Eigen::Vector4d PlaneOf(const FloorReport& floor) { return {0, 0, 1, -floor.height_m}; }

class OwnPoseSequence : public Sequence {
 public:
  OwnPoseSequence(std::shared_ptr<const Sequence> given, std::shared_ptr<OwnPoseStore> poses)
      : given_(std::move(given)), poses_(std::move(poses)) {}

  const Sequence& given() const { return *given_; }
  const std::shared_ptr<OwnPoseStore>& poses() const { return poses_; }

  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    PLB_CHECK(index >= 0 && index < num_frames()) << "frame " << index << " of " << num_frames();
    const auto known = poses_->At(index);
    return known && known->pose ? std::optional(known->pose->world_from_cam) : std::nullopt;
  }
  PoseUncertainty pose_uncertainty(int index) const override {
    const auto known = poses_->At(index);
    return known && known->pose ? known->pose->uncertainty : PoseUncertainty();
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
  std::shared_ptr<OwnPoseStore> poses_;
};

/// Whether a floor is worth telling again: clearly better known, or elsewhere.
bool Differs(const FloorReport& now, const std::optional<FloorReport>& told) {
  return !told || now.std_m < 0.8 * told->std_m ||
         std::abs(now.height_m - told->height_m) > 0.5 * told->std_m;
}

}  // namespace

OwnPoseStore::OwnPoseStore(std::unique_ptr<OwnPoseFeed> feed)
    : feed_(std::move(feed)), thread_([this](const std::stop_token& stop) { Follow(stop); }) {}

OwnPoseStore::~OwnPoseStore() = default;

void OwnPoseStore::Follow(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!ended_ && changed_.wait(lock, stop, [&] { return feed_->next() < wanted_; })) {
    lock.unlock();
    const bool looked = feed_->Next(stop);
    const OwnPoses& now = feed_->poses();
    lock.lock();
    ended_ = !looked;
    if (looked) {
      found_.frames.push_back(now.frames[found_.frames.size()]);
      if (found_.frames.size() > kTracksKept) {
        const std::size_t old = found_.frames.size() - 1 - kTracksKept;
        std::vector<TrackReport>().swap(found_.frames[old].tracks);
        feed_->ForgetTracks(old);
      }
      found_.loops = now.loops;
      found_.corrections.insert(
          found_.corrections.end(),
          now.corrections.begin() + static_cast<std::ptrdiff_t>(found_.corrections.size()),
          now.corrections.end());
    }
    changed_.notify_all();
  }
}

void OwnPoseStore::Advance(int frame, const std::stop_token& stop) {
  if (all_ != nullptr) return;
  std::unique_lock lock(mutex_);
  wanted_ = std::max(wanted_, frame + 1 + kImagesAhead);
  changed_.notify_all();
  changed_.wait(lock, stop,
                [&] { return ended_ || static_cast<int>(found_.frames.size()) > frame; });
}

std::optional<OwnPoseStore::Known> OwnPoseStore::At(int frame) const {
  const std::lock_guard lock(mutex_);
  const auto at = static_cast<std::size_t>(frame);
  if (at >= poses().frames.size()) return std::nullopt;
  const OwnPoseReport& report = poses().frames[at];
  Known known;
  known.waits_for = report.waits_for;
  known.floor = report.floor;
  known.points_in_world = report.points_in_world;
  if (report.ready && report.world_from_cam) {
    known.pose = PoseEstimate{PoseId{frame},
                              report.vio.stamp_ns,
                              *report.world_from_cam,
                              {.drift = report.cam_covariance},
                              poses().EpochAt(frame)};
  }
  return known;
}

std::vector<PastCorrection> OwnPoseStore::Corrections(std::size_t from) const {
  const std::lock_guard lock(mutex_);
  const auto& all = poses().corrections;
  return {all.begin() + static_cast<std::ptrdiff_t>(std::min(from, all.size())), all.end()};
}

std::optional<FloorReport> OwnPoseStore::last_floor() const {
  const std::lock_guard lock(mutex_);
  return poses().last_floor();
}

int OwnPoseStore::known() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(poses().frames.size());
}

OwnPoseStore::Growth OwnPoseStore::Since(std::size_t image, std::size_t correction,
                                         std::size_t most_images,
                                         std::size_t most_corrections) const {
  const std::lock_guard lock(mutex_);
  const auto part = [](const auto& all, std::size_t from, std::size_t most) {
    const std::size_t begin = std::min(from, all.size());
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(begin);
    return std::vector(first,
                       first + static_cast<std::ptrdiff_t>(std::min(most, all.size() - begin)));
  };
  Growth growth;
  growth.poses.frames = part(poses().frames, image, most_images);
  growth.poses.corrections = part(poses().corrections, correction, most_corrections);
  growth.poses.loops = poses().loops;
  growth.images = static_cast<int>(poses().frames.size());
  growth.ended = all_ != nullptr || ended_;
  return growth;
}

std::shared_ptr<const OwnPoses> OwnPoseStore::Copy() const {
  if (all_ != nullptr) return all_;
  const std::lock_guard lock(mutex_);
  return std::make_shared<const OwnPoses>(found_);
}

std::shared_ptr<const Sequence> WithOwnPoses(std::shared_ptr<const Sequence> given,
                                             std::shared_ptr<const OwnPoses> poses) {
  return std::make_shared<const OwnPoseSequence>(std::move(given),
                                                 std::make_shared<OwnPoseStore>(std::move(poses)));
}

std::shared_ptr<const Sequence> WithOwnPoses(std::shared_ptr<const Sequence> given,
                                             std::unique_ptr<OwnPoseFeed> feed) {
  return std::make_shared<const OwnPoseSequence>(std::move(given),
                                                 std::make_shared<OwnPoseStore>(std::move(feed)));
}

std::shared_ptr<OwnPoseStore> OwnPoseStoreOf(const Sequence& sequence) {
  const auto* own = dynamic_cast<const OwnPoseSequence*>(&sequence);
  return own == nullptr ? nullptr : own->poses();
}

std::shared_ptr<const OwnPoses> OwnPosesOf(const Sequence& sequence) {
  const auto store = OwnPoseStoreOf(sequence);
  return store == nullptr ? nullptr : store->Copy();
}

const Sequence& GivenSequence(const Sequence& sequence) {
  const auto* own = dynamic_cast<const OwnPoseSequence*>(&sequence);
  return own == nullptr ? sequence : own->given();
}

OwnPoseSource::OwnPoseSource(const std::shared_ptr<const Sequence>& sequence)
    : poses_(OwnPoseStoreOf(*sequence)),
      folder_(sequence, GrowingRecordingOf(GivenSequence(*sequence))) {
  PLB_CHECK(poses_ != nullptr);
}

std::string OwnPoseSource::WaitsFor(int frame) const {
  const auto known = poses_->At(frame);
  return known ? known->waits_for : std::string();
}

std::optional<PoseEstimate> OwnPoseSource::Pose(int frame) const {
  auto known = poses_->At(frame);
  if (!known || !known->pose) return std::nullopt;
  known->pose->stamp_ns = folder_.Frame(frame).stamp_ns;
  return std::move(known->pose);
}

void OwnPoseSource::Seek(int frame) {
  held_.clear();
  told_.reset();
  told_corrections_ = 0;
  next_ = frame;
  poses_->Advance(frame - 1, {});
  folder_.Seek(frame);
  // A floor is told as often as it would have been from the first frame on; points are told again,
  // and moved as often.
  std::optional<FloorReport> last;
  for (int i = 0; i < frame; ++i) {
    const auto known = poses_->At(i);
    if (!known) break;
    if (known->floor && Differs(*known->floor, last)) last = known->floor;
    TellCorrections(i);
    TellPoints(i);
  }
  const std::int64_t stamp_ns = frame > 0 ? folder_.Frame(frame - 1).stamp_ns : 0;
  if (last) {
    told_ = last;
    held_.push_back(FloorEstimate{stamp_ns, PlaneOf(*last), 0, last->std_m});
  }
}

void OwnPoseSource::TellCorrections(int frame) {
  for (const PastCorrection& correction : poses_->Corrections(told_corrections_)) {
    if (correction.image > frame) return;
    ++told_corrections_;
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
  auto known = poses_->At(frame);
  const std::optional<PoseEstimate> pose = Pose(frame);
  if (!known || !pose || known->points_in_world.empty()) return;
  held_.push_back(PointEstimates{pose->stamp_ns, std::move(known->points_in_world), *pose});
}

Result<std::optional<Packet>> OwnPoseSource::Next(const std::stop_token& stop) {
  if (held_.empty()) {
    poses_->Advance(next_, stop);
    Result<std::optional<Packet>> packet = folder_.Next(stop);
    while (packet.ok() && *packet && std::holds_alternative<FloorEstimate>(**packet))
      packet = folder_.Next(stop);  // of the whole sequence: not known yet
    if (!packet.ok() || !*packet) return packet;
    if (auto* pose = std::get_if<PoseEstimate>(&**packet)) {
      *pose = *Pose(pose->id.value);
      TellCorrections(pose->id.value);
    }
    if (const auto* frame = std::get_if<FramePacket>(&**packet)) {
      next_ = frame->frame + 1;
      const auto known = poses_->At(frame->frame);
      if (known && known->floor && Differs(*known->floor, told_)) {
        told_ = known->floor;
        held_.push_back(FloorEstimate{frame->stamp_ns, PlaneOf(*told_), 0, told_->std_m});
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
  const std::vector<PastCorrection> corrections = OwnPoseStoreOf(*sequence)->Corrections(0);
  LandmarkLoops loops(recipe.own_poses.closing);
  std::size_t told = 0;  // corrections
  const int end = std::min(last_frame + 1, source.num_frames());
  for (int frame = recipe.frames.begin; frame < end; frame += recipe.frames.step) {
    for (; told < corrections.size() && corrections[told].image <= frame; ++told) {
      const PastCorrection& correction = corrections[told];
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
