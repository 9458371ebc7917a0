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
constexpr std::size_t kImagesAhead = 16;
constexpr double kGrownPause_ms = 1000;  ///< Poses of a live run are kept about as often.

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

OwnPoseStore::OwnPoseStore(std::shared_ptr<const OwnPoses> all) : all_(std::move(all)) {}

OwnPoseStore::OwnPoseStore(std::unique_ptr<OwnPoseFeed> feed, std::size_t first_image,
                           std::size_t first_correction)
    : feed_(std::move(feed)),
      first_image_(first_image),
      first_correction_(first_correction),
      thread_([this](const std::stop_token& stop) { Follow(stop); }) {}

OwnPoseStore::~OwnPoseStore() = default;

void OwnPoseStore::Follow(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!ended_ && changed_.wait(lock, stop, [&] { return end() < wanted_; })) {
    lock.unlock();
    const bool looked = feed_->Next(stop);
    OwnPoseReport report;
    std::vector<PastCorrection> corrections;
    if (looked) {
      report = feed_->TakeReport();
      corrections = feed_->TakeCorrections();
    }
    lock.lock();
    ended_ = !looked;
    if (looked) Keep(std::move(report), std::move(corrections));
    changed_.notify_all();
  }
}

OwnPoseStore::OldPose OwnPoseStore::ShortOf(const OwnPoseReport& report) {
  OldPose old;
  old.stamp_ns = report.vio.stamp_ns;
  old.ready = report.ready;
  old.has_pose = report.world_from_cam.has_value();
  if (!old.has_pose) return old;
  old.world_from_cam = report.world_from_cam->matrix().topRows<3>();
  old.body_in_world = report.vio.world_from_body.translation();
  for (int row = 0, i = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column)
      old.cam_covariance[i++] = report.cam_covariance(row, column);
  }
  return old;
}

OwnPoseReport OwnPoseStore::ReportOf(const OldPose& old) {
  OwnPoseReport report;
  report.vio.stamp_ns = old.stamp_ns;
  report.ready = old.ready;
  if (!old.ready) report.waits_for = "why it had no pose was let go of";
  if (!old.has_pose) return report;
  report.world_from_cam.emplace();
  report.world_from_cam->matrix().topRows<3>() = old.world_from_cam;
  report.world_from_cam->makeAffine();
  report.vio.world_from_body.translation() = old.body_in_world;
  for (int row = 0, i = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column, ++i)
      report.cam_covariance(row, column) = report.cam_covariance(column, row) =
          old.cam_covariance[i];
  }
  return report;
}

void OwnPoseStore::Keep(OwnPoseReport report, std::vector<PastCorrection> corrections) {
  recent_.push_back(std::move(report));
  if (recent_.size() > kTracksKept)
    std::vector<TrackReport>().swap(recent_[recent_.size() - 1 - kTracksKept].tracks);
  if (recent_.size() > kReportsKept) {
    old_.push_back(ShortOf(recent_.front()));
    recent_.pop_front();
  }
  for (PastCorrection& correction : corrections) {
    corrections_.push_back(std::move(correction));
    if (corrections_.size() > kCorrectionsKept)
      corrections_[corrections_.size() - 1 - kCorrectionsKept].past = {};
  }
  loops_ = feed_->loops();
}

template <typename Use>
auto OwnPoseStore::WithReport(std::size_t image, Use use) const {
  if (all_ != nullptr) return use(all_->frames[image]);
  const std::size_t at = image - first_image_;
  return at < old_.size() ? use(ReportOf(old_[at])) : use(recent_[at - old_.size()]);
}

int OwnPoseStore::EpochAt(int image) const {
  return all_ != nullptr ? all_->EpochAt(image) : loops_.EpochAt(image);
}

std::span<const PastCorrection> OwnPoseStore::corrections() const {
  return all_ != nullptr ? all_->corrections : corrections_;
}

std::optional<PoseEstimate> OwnPoseStore::EstimateOf(const OwnPoseReport& report, int frame) const {
  if (!report.ready || !report.world_from_cam) return std::nullopt;
  return PoseEstimate{PoseId{frame},
                      report.vio.stamp_ns,
                      *report.world_from_cam,
                      {.drift = report.cam_covariance},
                      EpochAt(frame)};
}

void OwnPoseStore::Advance(int frame, const std::stop_token& stop) {
  if (all_ != nullptr || frame < 0) return;
  const auto next = static_cast<std::size_t>(frame) + 1;
  std::unique_lock lock(mutex_);
  wanted_ = std::max(wanted_, next + kImagesAhead);
  changed_.notify_all();
  changed_.wait(lock, stop, [&] { return ended_ || end() >= next; });
}

std::optional<OwnPoseStore::Known> OwnPoseStore::At(int frame) const {
  const std::lock_guard lock(mutex_);
  const auto image = static_cast<std::size_t>(frame);
  if (frame < 0 || image < first_image_ || image >= end()) return std::nullopt;
  return WithReport(image, [&](const OwnPoseReport& report) {
    return Known{EstimateOf(report, frame), report.waits_for, report.floor, report.points_in_world};
  });
}

std::optional<int> OwnPoseStore::ImageOfCorrection(std::size_t number) const {
  const std::lock_guard lock(mutex_);
  if (number < first_correction_ || number - first_correction_ >= corrections().size())
    return std::nullopt;
  return corrections()[number - first_correction_].image;
}

std::vector<PoseEstimate> OwnPoseStore::CorrectedPast(std::size_t number) const {
  const std::lock_guard lock(mutex_);
  const auto all = corrections();
  const PastCorrection& correction = all[number - first_correction_];
  std::vector<PoseEstimate> poses;
  if (correction.past.empty()) return poses;
  const int end = std::min(correction.image, known_images());
  for (int i = static_cast<int>(first_image_); i < end; ++i) {
    WithReport(static_cast<std::size_t>(i), [&](const OwnPoseReport& report) {
      auto pose = EstimateOf(report, i);
      if (!pose) return;
      pose->world_from_cam = CorrectedBy(
          correction, all,
          {i, pose->stamp_ns, pose->world_from_cam, report.vio.world_from_body.translation()});
      pose->epoch = correction.epoch;
      poses.push_back(*std::move(pose));
    });
  }
  return poses;
}

std::optional<FloorReport> OwnPoseStore::last_floor() const {
  const std::lock_guard lock(mutex_);
  if (all_ != nullptr) return all_->last_floor();
  return recent_.empty() ? std::nullopt : recent_.back().floor;
}

int OwnPoseStore::known() const {
  const std::lock_guard lock(mutex_);
  return known_images();
}

OwnPoseGrowth OwnPoseStore::Since(std::size_t image, std::size_t correction,
                                  std::size_t most_images, std::size_t most_corrections) const {
  const std::lock_guard lock(mutex_);
  OwnPoseGrowth growth;
  growth.first_image = std::max(image, first_image_);
  for (std::size_t i = growth.first_image; i < end() && growth.poses.frames.size() < most_images;
       ++i)
    growth.poses.frames.push_back(
        WithReport(i, [](const OwnPoseReport& report) { return report; }));
  const auto all = corrections();
  const std::size_t from =
      std::min(std::max(correction, first_correction_) - first_correction_, all.size());
  const auto part = all.subspan(from, std::min(most_corrections, all.size() - from));
  growth.poses.corrections.assign(part.begin(), part.end());
  growth.poses.loops = all_ != nullptr ? all_->loops : loops_;
  growth.images = known_images();
  growth.ended = all_ != nullptr || ended_;
  return growth;
}

std::shared_ptr<const OwnPoseGrowth> OwnPosesTaken::Rest(const OwnPoseStore& store) {
  since_taken_ = Stopwatch();
  auto growth = std::make_shared<const OwnPoseGrowth>(store.Since(images_, corrections_));
  images_ = growth->first_image + growth->poses.frames.size();
  corrections_ += growth->poses.corrections.size();
  return growth;
}

std::shared_ptr<const OwnPoseGrowth> OwnPosesTaken::NowAndThen(const OwnPoseStore& store) {
  if (since_taken_ && since_taken_->Milliseconds() < kGrownPause_ms) return nullptr;
  return Rest(store);
}

std::shared_ptr<const OwnPoses> OwnPoseStore::Copy() const {
  if (all_ != nullptr) return all_;
  return std::make_shared<const OwnPoses>(std::move(Since(0, 0).poses));
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
  for (auto image = poses_->ImageOfCorrection(told_corrections_); image && *image <= frame;
       image = poses_->ImageOfCorrection(++told_corrections_)) {
    for (PoseEstimate& pose : poses_->CorrectedPast(told_corrections_)) {
      pose.stamp_ns = folder_.Frame(pose.id.value).stamp_ns;
      held_.push_back(std::move(pose));
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
  const auto store = OwnPoseStoreOf(*sequence);
  LandmarkLoops loops(recipe.own_poses.closing);
  std::size_t told = 0;  // corrections
  const int end = std::min(last_frame + 1, source.num_frames());
  for (int frame = recipe.frames.begin; frame < end; frame += recipe.frames.step) {
    for (auto image = store->ImageOfCorrection(told); image && *image <= frame;
         image = store->ImageOfCorrection(++told)) {
      for (PoseEstimate& pose : store->CorrectedPast(told)) {
        pose.stamp_ns = source.Frame(pose.id.value).stamp_ns;
        loops.See(pose);
      }
      loops.Refresh();
    }
    if (const auto pose = source.Pose(frame)) loops.See(*pose);
    if (const auto seen = history.find(frame); seen != history.end()) loops.Add(seen->second);
  }
  return loops;
}

}  // namespace plumbline
