// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/growing_sequence.h"

#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/file_lock.h"
#include "engine/base/log.h"
#include "engine/dataset/growing_recording.h"
#include "engine/dataset/text_table.h"
#include "engine/sensor/image_file.h"
#include "engine/sensor/undistorter.h"

namespace plumbline {
namespace {

constexpr auto kLookPeriod = std::chrono::milliseconds(4);
constexpr std::size_t kMostBytesAtOnce = 4u << 20;

std::int64_t SteadyNs() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

/// The complete lines that were appended to a file since it was looked at last.
class GrowingLines {
 public:
  explicit GrowingLines(std::filesystem::path file) : file_(std::move(file)) {}

  template <typename Row>
  void Read(const Row& row) {
    std::ifstream stream(file_, std::ios::binary);
    if (!stream || !stream.seekg(read_)) return;
    std::string text(kMostBytesAtOnce, '\0');
    while (stream.read(text.data(), static_cast<std::streamsize>(text.size())),
           stream.gcount() > 0) {
      std::string_view more(text.data(), static_cast<std::size_t>(stream.gcount()));
      const std::size_t end = more.rfind('\n');
      if (end == std::string_view::npos) return;
      more = more.substr(0, end + 1);
      read_ += static_cast<std::streamoff>(more.size());
      for (const std::string_view line : SplitLines(more)) {
        const bool heading = lines_++ == 0;
        const std::vector<std::string_view> fields = SplitFields(line);
        if (fields.empty() || fields[0].starts_with('#')) continue;
        const std::optional<std::int64_t> stamp = ParseStampNs(fields[0]);
        if (stamp && row(*stamp, fields)) continue;
        if (!stamp && heading) continue;
        if (left_out_++ == 0)
          log::warn("'{}' line {} is not a row of it, or not later; left out", file_.string(),
                    lines_);
      }
      stream.clear();
      stream.seekg(read_);
    }
  }

 private:
  std::filesystem::path file_;
  std::streamoff read_ = 0;
  int lines_ = 0, left_out_ = 0;
};

class GrowingSequence : public Sequence, public GrowingRecording {
 public:
  explicit GrowingSequence(std::filesystem::path folder)
      : folder_(std::move(folder)),
        frame_lines_(folder_ / "color.csv"),
        imu_lines_(folder_ / "imu.csv"),
        thread_([this](const std::stop_token& stop) { Follow(stop); }) {}

  /// Reads what is written once: camera and IMU. After the first frames came.
  Status ReadCalibration() {
    auto opened = OpenSequence(folder_, {});
    if (!opened.ok()) return opened.error();
    as_opened_ = *opened;
    undistorter_.emplace(as_opened_->calibration().cameras.front().camera);
    return {};
  }

  bool HasFrame(int frame) const override { return frame < num_frames(); }
  bool WaitForFrame(int frame, const std::stop_token& stop) const override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return ended_ || frame < NumFrames(); });
    return frame < NumFrames();
  }
  std::vector<ImuSample> WaitForImu(std::size_t from, std::int64_t time_ns,
                                    const std::stop_token& stop) const override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] {
      return ended_ || (!samples_.empty() && samples_.back().stamp_ns > time_ns) ||
             (!frames_.empty() && frames_.back().stamp_ns > time_ns + kSilentImu_ns);
    });
    from = std::min(from, samples_.size());
    return {samples_.begin() + static_cast<std::ptrdiff_t>(from), samples_.end()};
  }
  std::int64_t CameNs(int frame) const override { return FrameAt(frame).came_ns; }
  bool ended() const override {
    const std::lock_guard lock(mutex_);
    return ended_;
  }

  const std::filesystem::path& path() const override { return folder_; }
  int num_frames() const override {
    const std::lock_guard lock(mutex_);
    return NumFrames();
  }
  const PinholeCamera& camera() const override { return as_opened_->camera(); }
  const Calibration& calibration() const override { return as_opened_->calibration(); }
  double rate_hz() const override { return as_opened_->rate_hz(); }
  std::int64_t stamp_ns(int index) const override { return FrameAt(index).stamp_ns; }
  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    FrameAt(index);
    return std::nullopt;
  }
  std::optional<Eigen::Vector3d> gravity_in_world() const override { return std::nullopt; }
  std::optional<Eigen::Vector4d> floor_in_world() const override { return std::nullopt; }
  Result<Frame> ReadFrame(int index) const override {
    const Result<cv::Mat> image = ReadRawImage(index);
    if (!image.ok()) return image.error();
    return Frame{index, stamp_ns(index), undistorter_->Undistort(*image), std::nullopt};
  }
  Result<cv::Mat> ReadRawImage(int index) const override {
    const PinholeCamera& size = camera();
    return ReadImage(folder_ / "color" / FrameAt(index).file, ImageKind::kColor,
                     cv::Size(size.width, size.height));
  }
  Result<std::optional<cv::Mat>> ReadDepth(int) const override { return std::optional<cv::Mat>(); }
  Result<std::optional<EdgeMap>> ReadEdges(int) const override { return std::optional<EdgeMap>(); }
  Result<std::optional<std::vector<Detection>>> ReadProposals(int) const override {
    return std::optional<std::vector<Detection>>();
  }
  Result<ImuRecording> ReadImu() const override {
    const std::lock_guard lock(mutex_);
    return ImuRecording{{samples_.begin(), samples_.end()}, {}};
  }
  bool has_images() const override { return true; }
  bool has_imu() const override { return true; }
  bool has_depth() const override { return false; }
  bool has_edges() const override { return false; }
  bool has_proposals() const override { return false; }
  std::optional<std::filesystem::path> scene_file() const override { return std::nullopt; }
  std::optional<std::filesystem::path> ground_truth_file() const override { return std::nullopt; }
  std::optional<std::filesystem::path> models_folder() const override {
    return as_opened_->models_folder();
  }
  std::optional<std::filesystem::path> tracks_file() const override { return std::nullopt; }
  std::optional<std::filesystem::path> reference_file() const override { return std::nullopt; }
  const std::vector<std::string>& warnings() const override { return as_opened_->warnings(); }

 private:
  struct ComeFrame {
    std::int64_t stamp_ns = 0;
    std::string file;  ///< Name inside color/.
    std::int64_t came_ns = 0;
  };

  int NumFrames() const { return static_cast<int>(frames_.size()); }
  ComeFrame FrameAt(int index) const {
    const std::lock_guard lock(mutex_);
    PLB_CHECK(index >= 0 && index < NumFrames()) << "frame " << index << " of " << NumFrames();
    return frames_[static_cast<std::size_t>(index)];
  }

  void Follow(const std::stop_token& stop) {
    std::mutex unused;
    std::condition_variable_any wakes;
    while (!stop.stop_requested()) {
      // Asked before the files are read: what was written last is read before it counts as ended.
      const bool written = IsBeingRecorded(folder_);
      LookForMore();
      if (!written) break;
      std::unique_lock lock(unused);
      wakes.wait_for(lock, stop, kLookPeriod, [] { return false; });
    }
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }

  void LookForMore() {
    std::vector<ComeFrame> frames;
    std::vector<ImuSample> samples;
    imu_lines_.Read([&](std::int64_t stamp_ns, const std::vector<std::string_view>& fields) {
      if (fields.size() != 7 || stamp_ns <= last_sample_ns_) return false;
      std::array<double, 6> numbers;
      for (std::size_t i = 0; i < 6; ++i) {
        const std::optional<double> number = ParseNumber(fields[i + 1]);
        if (!number || !std::isfinite(*number)) return false;
        numbers[i] = *number;
      }
      last_sample_ns_ = stamp_ns;
      samples.push_back(
          {stamp_ns, {numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}});
      return true;
    });
    frame_lines_.Read([&](std::int64_t stamp_ns, const std::vector<std::string_view>& fields) {
      const std::filesystem::path file = fields.size() == 2 ? fields[1] : "";
      if (!IsImageName(file) || stamp_ns <= last_frame_ns_) return false;
      if (file.has_parent_path() && file.parent_path() != "color") return false;
      last_frame_ns_ = stamp_ns;
      frames.push_back({stamp_ns, file.filename().string(), SteadyNs()});
      return true;
    });
    if (frames.empty() && samples.empty()) return;
    const std::lock_guard lock(mutex_);
    frames_.insert(frames_.end(), frames.begin(), frames.end());
    samples_.insert(samples_.end(), samples.begin(), samples.end());
    changed_.notify_all();
  }

  const std::filesystem::path folder_;
  std::shared_ptr<const Sequence> as_opened_;
  std::optional<Undistorter> undistorter_;

  // Of the thread.
  GrowingLines frame_lines_, imu_lines_;
  std::int64_t last_frame_ns_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t last_sample_ns_ = std::numeric_limits<std::int64_t>::min();

  mutable std::mutex mutex_;  ///< Of what follows.
  mutable std::condition_variable_any changed_;
  std::deque<ComeFrame> frames_;
  std::deque<ImuSample> samples_;
  bool ended_ = false;
  std::jthread thread_;  ///< Last: stops before what it uses goes.
};

}  // namespace

const GrowingRecording* GrowingRecordingOf(const Sequence& sequence) {
  return dynamic_cast<const GrowingRecording*>(&sequence);
}

bool IsBeingRecorded(const std::filesystem::path& folder) {
  return FileLock::IsHeld(folder / "color.csv");
}

Result<std::shared_ptr<const Sequence>> FollowRecording(const std::filesystem::path& folder,
                                                        const WorkContext& work) {
  auto sequence = std::make_shared<GrowingSequence>(folder);
  work.report({"Waiting for the first images and readings of the recording"});
  const bool images = sequence->WaitForFrame(1, work.stop);
  const auto readings = sequence->WaitForImu(
      0, images ? sequence->stamp_ns(0) : std::numeric_limits<std::int64_t>::max(), work.stop);
  if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  if (!images) {
    return Error{ErrorCode::kNotFound,
                 "the recording '" + folder.string() + "' ended before it had two images"};
  }
  if (readings.empty()) {
    return Error{ErrorCode::kNotFound, "the recording '" + folder.string() +
                                           "' has images and no readings of an IMU; poses come "
                                           "from both"};
  }
  if (Status status = sequence->ReadCalibration(); !status.ok()) return status.error();
  return std::shared_ptr<const Sequence>(std::move(sequence));
}

}  // namespace plumbline
