// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/remote_sequence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/log.h"
#include "engine/dataset/growing_recording.h"
#include "engine/nodes/own_pose_message.h"
#include "engine/transport/wire_values.h"

namespace plumbline {
namespace {

Error BadSequence(const std::string& what) {
  return {ErrorCode::kCorrupt,
          "the player sent a sequence whose " + what + "; is it another program's?"};
}

bool IsFinite(std::initializer_list<double> values) {
  for (const double value : values)
    if (!std::isfinite(value)) return false;
  return true;
}

Result<PoseCovariance> CovarianceFromWire(const google::protobuf::RepeatedField<double>& values) {
  PoseCovariance covariance = PoseCovariance::Zero();
  if (values.empty()) return covariance;
  if (values.size() != 36) return BadSequence("covariance is none");
  for (int i = 0; i < 36; ++i) {
    if (!std::isfinite(values[i])) return BadSequence("covariance is none");
    covariance(i / 6, i % 6) = values[i];
  }
  return covariance;
}

std::optional<std::filesystem::path> FileFromWire(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional<std::filesystem::path>(text);
}

Eigen::Vector3d VectorFromWire(const wire::Vector3& v) { return {v.x(), v.y(), v.z()}; }

constexpr auto kGrowthPeriod = std::chrono::milliseconds(10);
/// A frame that is told of and not here yet is at most so many after the last one that is.
constexpr int kMostToldAhead = 100;
constexpr std::size_t kReadingsKept = 20'000;  ///< Of those that were asked for.

Result<SharedReply> AskForSequence(NodeClient& player, const std::stop_token& stop) {
  wire::Request request;
  request.mutable_sequence();
  return player.AskAndWait(std::move(request), stop);
}

}  // namespace

wire::Request ImageRequestOf(int frame) {
  wire::Request request;
  request.mutable_image()->set_frame(frame);
  return request;
}

wire::Request RawImageRequestOf(int frame) {
  wire::Request request = ImageRequestOf(frame);
  request.mutable_image()->set_raw(true);
  return request;
}

wire::Request EdgesRequestOf(int frame) {
  wire::Request request;
  request.mutable_edges()->set_frame(frame);
  return request;
}

wire::Request ProposalsRequestOf(int frame) {
  wire::Request request;
  request.mutable_proposals()->set_frame(frame);
  return request;
}

Result<EdgeMap> EdgesFromWire(const wire::Edges& edges) {
  EdgeMap map;
  Result<cv::Mat> probability = PixelsFromWire(edges.probability());
  if (!probability.ok()) return probability.error();
  Result<cv::Mat> angle = PixelsFromWire(edges.angle());
  if (!angle.ok()) return angle.error();
  map.probability = std::move(probability).value();
  map.angle = std::move(angle).value();
  if (map.probability.size() != map.angle.size() ||
      (!map.empty() && (map.probability.type() != CV_8UC1 || map.angle.type() != CV_8UC1)))
    return Error{ErrorCode::kCorrupt, "a node sent edges whose two maps do not fit one another"};
  return map;
}

/// One that the player records.
class GrowingRemoteSequence : public RemoteSequence, public GrowingRecording {
 public:
  ~GrowingRemoteSequence() override {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
  }

  /// @param readings  Whether the IMU's are wanted.
  void Start(NodeClient& player, bool readings) {
    thread_ = std::jthread(
        [this, &player, readings](const std::stop_token& stop) { Follow(player, readings, stop); });
  }

  bool HasFrame(int frame) const override { return frame < num_frames(); }
  bool WaitForFrame(int frame, const std::stop_token& stop) const override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return ended_ || Has(frame); });
    return Has(frame);
  }
  std::vector<ImuSample> WaitForImu(std::size_t from, std::int64_t time_ns,
                                    const std::stop_token& stop) const override {
    std::unique_lock lock(mutex_);
    std::vector<ImuSample>& samples = imu_.samples;
    changed_.wait(lock, stop, [&] {
      return ended_ || (!samples.empty() && samples.back().stamp_ns > time_ns) ||
             (!frames_.empty() && frames_.back().stamp_ns > time_ns + kSilentImu_ns);
    });
    if (from > forgotten_ + kReadingsKept && !samples.empty()) {
      // Whoever asks has those before. The last one tells how far the IMU has been read.
      const std::size_t old = std::min(from - forgotten_, samples.size()) - 1;
      samples.erase(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(old));
      forgotten_ += old;
    }
    const std::size_t first = std::min(std::max(from, forgotten_) - forgotten_, samples.size());
    return {samples.begin() + static_cast<std::ptrdiff_t>(first), samples.end()};
  }
  std::int64_t CameNs(int frame) const override { return RowOf(frame).came_ns; }
  bool ended() const override {
    const std::lock_guard lock(mutex_);
    return ended_;
  }

 private:
  bool Has(int frame) const { return frame < static_cast<int>(frames_.size()); }

  void Follow(NodeClient& player, bool readings, const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      wire::Request request;
      request.mutable_growth()->set_frames(num_frames());
      request.mutable_growth()->set_readings(NumReadings(readings));
      const Result<SharedReply> reply = player.AskAndWait(std::move(request), stop);
      Status status = reply.ok() ? Add((*reply)->growth(), readings) : Status(reply.error());
      if (!status.ok() && !stop.stop_requested()) log::warn("{}", status.error().message);
      if (!status.ok() || (*reply)->growth().ended()) break;
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, stop, kGrowthPeriod, [] { return false; });
    }
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }

  int NumReadings(bool wanted) const {
    if (!wanted) return kEveryReading;
    const std::lock_guard lock(mutex_);
    return static_cast<int>(forgotten_ + imu_.samples.size());
  }

  Status Add(const wire::Growth& growth, bool readings) {
    const std::int64_t now_ns =
        std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
    const std::lock_guard lock(mutex_);
    for (const std::int64_t stamp_ns : growth.frame_stamps_ns()) {
      if (!frames_.empty() && stamp_ns < frames_.back().stamp_ns) return BadSequence("stamps fall");
      FrameRow row;
      row.stamp_ns = stamp_ns;
      row.came_ns = now_ns;
      frames_.push_back(row);
    }
    if (readings) {
      if (Status status = AddGrowthFromWire(growth, imu_.samples); !status.ok()) return status;
    }
    changed_.notify_all();
    return {};
  }

  bool ended_ = false;
  mutable std::size_t forgotten_ = 0;  ///< Readings before those that are kept.
  std::jthread thread_;
};

/// The description; `ahead` as it is then.
Result<std::shared_ptr<RemoteSequence>> RemoteSequence::Ask(NodeClient& player, FramesAhead& ahead,
                                                            const std::stop_token& stop) {
  const Result<SharedReply> reply = AskForSequence(player, stop);
  if (!reply.ok()) return reply.error();
  const wire::Sequence& message = (*reply)->sequence();
  std::shared_ptr<RemoteSequence> sequence(message.grows() ? new GrowingRemoteSequence()
                                                           : new RemoteSequence());
  if (Status status = sequence->Take(message); !status.ok()) return status.error();
  sequence->stop_ = stop;
  if (message.grows()) {
    ahead.window = 1;  // what comes next has not come yet
  } else {
    ahead.end = std::min(ahead.end, sequence->num_frames());
  }
  return sequence;
}

Result<std::shared_ptr<const RemoteSequence>> RemoteSequence::Open(NodeClient& player,
                                                                   FramesAhead ahead,
                                                                   std::stop_token stop) {
  auto sequence = Ask(player, ahead, stop);
  if (!sequence.ok()) return sequence.error();
  (*sequence)->AskAhead(player, ahead);
  if (auto* growing = dynamic_cast<GrowingRemoteSequence*>(sequence->get()))
    growing->Start(player, false);
  return std::shared_ptr<const RemoteSequence>(std::move(sequence).value());
}

Result<std::shared_ptr<const RemoteSequence>> RemoteSequence::OpenForFilter(NodeClient& player,
                                                                            FramesAhead ahead,
                                                                            std::stop_token stop) {
  auto asked = Ask(player, ahead, stop);
  if (!asked.ok()) return asked.error();
  const std::shared_ptr<RemoteSequence>& sequence = *asked;
  sequence->raw_images_ = std::make_unique<RequestsAhead>(player, ahead, RawImageRequestOf);
  auto* growing = dynamic_cast<GrowingRemoteSequence*>(sequence.get());
  while (true) {
    wire::Request rest;
    rest.mutable_imu()->set_from(static_cast<int>(sequence->imu_.samples.size()));
    const Result<SharedReply> more = player.AskAndWait(std::move(rest), stop);
    if (!more.ok()) return more.error();
    const auto complete =
        AddImuFromWire((*more)->imu(), sequence->calibration_, sequence->imu_.samples);
    if (!complete.ok()) return complete.error();
    if (*complete || growing != nullptr) break;
  }
  if (growing != nullptr) growing->Start(player, true);
  return std::shared_ptr<const RemoteSequence>(sequence);
}

void RemoteSequence::AskAhead(NodeClient& player, const FramesAhead& ahead) {
  images_ = std::make_unique<RequestsAhead>(player, ahead, ImageRequestOf);
  edges_ = std::make_unique<RequestsAhead>(player, ahead, EdgesRequestOf);
  proposals_ = std::make_unique<RequestsAhead>(player, ahead, ProposalsRequestOf);
}

Result<std::shared_ptr<const RemoteSequence>> RemoteSequence::FromWire(
    const wire::Sequence& message, NodeClient* player, FramesAhead ahead, std::stop_token stop) {
  std::shared_ptr<RemoteSequence> sequence(new RemoteSequence());
  if (Status status = sequence->Take(message); !status.ok()) return status.error();
  sequence->stop_ = std::move(stop);
  ahead.end = std::min(ahead.end, sequence->num_frames());
  if (player != nullptr) sequence->AskAhead(*player, ahead);
  return std::shared_ptr<const RemoteSequence>(std::move(sequence));
}

RemoteSequence::FrameRow RemoteSequence::RowOf(int index) const {
  const std::lock_guard lock(mutex_);
  const auto at = static_cast<std::size_t>(index);
  PLB_CHECK(index >= 0 && at < frames_.size()) << "frame " << index << " of " << frames_.size();
  return frames_[at];
}

bool RemoteSequence::AwaitFrame(int index, const std::stop_token& stop) const {
  const int known = num_frames();
  if (index < 0) return false;
  const GrowingRecording* growing = GrowingRecordingOf(*this);
  if (growing == nullptr || index >= known + kMostToldAhead) return index < known;
  return growing->WaitForFrame(index, stop);
}

Status RemoteSequence::Take(const wire::Sequence& message) {
  path_ = message.path();
  const wire::Pinhole& camera = message.camera();
  camera_ = {camera.width(), camera.height(), camera.fx(), camera.fy(), camera.cx(), camera.cy()};
  constexpr int kMostSide = 1 << 15;
  if (camera_.width < 1 || camera_.height < 1 || camera_.width > kMostSide ||
      camera_.height > kMostSide || !(camera_.fx > 0 && camera_.fy > 0) ||
      !IsFinite({camera_.fx, camera_.fy, camera_.cx, camera_.cy}))
    return BadSequence("camera is none");
  Camera only;
  only.pinhole = camera_;
  only.rate_hz = rate_hz_ = message.rate_hz();
  if (!(rate_hz_ > 0) || !std::isfinite(rate_hz_)) return BadSequence("rate is none");
  calibration_.cameras = {{"camera", only}};
  std::int64_t last = std::numeric_limits<std::int64_t>::min();
  for (const wire::SequenceFrame& row : message.frames()) {
    FrameRow& frame = frames_.emplace_back();
    frame.stamp_ns = row.stamp_ns();
    if (frame.stamp_ns < last) return BadSequence("stamps fall");
    last = frame.stamp_ns;
    if (!row.has_pose()) continue;
    const auto pose = TransformFromWire(row.pose().world_from_cam());
    if (!pose.ok()) return pose.error();
    const auto drift = CovarianceFromWire(row.pose().drift());
    const auto own = CovarianceFromWire(row.pose().own());
    if (!drift.ok()) return drift.error();
    if (!own.ok()) return own.error();
    frame.given =
        std::make_shared<const GivenPose>(GivenPose{*pose, PoseUncertainty{*drift, *own}});
  }
  if (message.has_gravity_in_world()) {
    gravity_ = VectorFromWire(message.gravity_in_world());
    if (!(std::abs(gravity_->norm() - 1) < 1e-6)) return BadSequence("gravity is no unit vector");
  }
  if (message.floor_in_world_size() == 4) {
    floor_ = Eigen::Vector4d();
    for (int i = 0; i < 4; ++i) (*floor_)[i] = message.floor_in_world(i);
    if (!floor_->allFinite()) return BadSequence("floor is none");
  }
  floor_std_m_ = message.floor_std_m();
  for (const wire::FloorLevel& row : message.floor_levels()) {
    FloorLevel level{row.height_m(), row.std_m(), {}};
    for (const wire::Vector3& corner : row.outline_in_world())
      level.outline_in_world.push_back(VectorFromWire(corner));
    if (!IsFinite({level.height_m, level.std_m})) return BadSequence("floor has a bad level");
    levels_.push_back(std::move(level));
  }
  if (!std::isfinite(floor_std_m_) || floor_std_m_ < 0) return BadSequence("floor is none");
  has_images_ = message.has_images();
  has_edges_ = message.has_edges();
  has_proposals_ = message.has_proposals();
  models_folder_ = FileFromWire(message.models_folder());
  ground_truth_file_ = FileFromWire(message.ground_truth_file());
  scene_file_ = FileFromWire(message.scene_file());
  return {};
}

Result<Frame> RemoteSequence::ReadFrame(int index) const {
  Frame frame;
  frame.index = index;
  frame.stamp_ns = stamp_ns(index);
  frame.world_from_cam = world_from_cam(index);
  PLB_CHECK(images_ != nullptr);
  Result<cv::Mat> image =
      TakePixels(*images_, index, stop_, [&](const wire::Reply& reply) -> Result<cv::Mat> {
        Result<cv::Mat> pixels = PixelsFromWire(reply.image().pixels());
        if (!pixels.ok()) return pixels;
        if (pixels->size() != cv::Size(camera_.width, camera_.height) || pixels->type() != CV_8UC3)
          return Error{ErrorCode::kCorrupt,
                       "the player sent an image of another size than its "
                       "camera has, or not in colour"};
        return pixels;
      });
  if (!image.ok()) return image.error();
  frame.image = std::move(image).value();
  const std::lock_guard lock(mutex_);
  constexpr std::size_t kRemembered = 64;
  if (came_.size() >= kRemembered) came_.erase(came_.begin());
  came_[index] = std::chrono::steady_clock::now();
  return frame;
}

std::optional<double> RemoteSequence::AgeMs(int frame) const {
  const std::lock_guard lock(mutex_);
  const auto came = came_.find(frame);
  if (came == came_.end()) return std::nullopt;
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - came->second)
      .count();
}

Result<cv::Mat> RemoteSequence::ReadRawImage(int index) const {
  if (raw_images_ != nullptr) {
    const PinholeCamera& raw = calibration_.cameras.front().camera.pinhole;
    return TakePixels(*raw_images_, index, stop_, [&](const wire::Reply& reply) -> Result<cv::Mat> {
      Result<cv::Mat> pixels = PixelsFromWire(reply.image().pixels());
      if (pixels.ok() && pixels->size() != cv::Size(raw.width, raw.height))
        return Error{ErrorCode::kCorrupt,
                     "the player sent an image of another size than its camera "
                     "has"};
      return pixels;
    });
  }
  const Result<Frame> frame = ReadFrame(index);
  if (!frame.ok()) return frame.error();
  return frame->image;
}

Result<std::optional<EdgeMap>> RemoteSequence::ReadEdges(int index) const {
  PLB_CHECK(edges_ != nullptr);
  if (!has_edges_) return std::optional<EdgeMap>();
  Result<EdgeMap> edges = TakePixels(
      *edges_, index, stop_, [](const wire::Reply& reply) { return EdgesFromWire(reply.edges()); });
  if (!edges.ok()) {
    if (edges.error().code == ErrorCode::kNotFound) return std::optional<EdgeMap>();
    return edges.error();
  }
  return std::optional<EdgeMap>(std::move(edges).value());
}

Result<std::optional<std::vector<Detection>>> RemoteSequence::ReadProposals(int index) const {
  using Proposals = std::optional<std::vector<Detection>>;
  PLB_CHECK(proposals_ != nullptr);
  if (!has_proposals_) return Proposals();
  const Result<SharedReply> reply = proposals_->Get(index, stop_);
  if (!reply.ok()) {
    if (reply.error().code == ErrorCode::kNotFound) return Proposals();
    return reply.error();
  }
  Result<std::vector<Detection>> detections = ProposalsFromWire((*reply)->proposals());
  if (!detections.ok()) return detections.error();
  return Proposals(std::move(detections).value());
}

}  // namespace plumbline
