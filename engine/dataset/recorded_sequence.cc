// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/recorded_sequence.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/check.h"
#include "engine/dataset/stamp_statistics.h"
#include "engine/dataset/stamped_rows.h"
#include "engine/dataset/undistort.h"
#include "engine/geometry/path_floor.h"
#include "engine/sensor/image_file.h"
#include "engine/sensor/undistorter.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

class RecordedSequence : public Sequence {
 public:
  RecordedSequence(Recording recording, double rate_hz)
      : recording_(std::move(recording)), undistorter_(camera_), rate_hz_(rate_hz) {
    if (!recording_.gravity_in_world || !recording_.camera_height_m) return;
    std::vector<std::optional<Eigen::Isometry3d>> poses;
    for (const RecordedFrame& frame : recording_.frames) poses.push_back(frame.world_from_cam);
    floor_ = FloorUnderPath(poses, -*recording_.gravity_in_world, *recording_.camera_height_m);
  }

  const fs::path& path() const override { return recording_.path; }
  int num_frames() const override { return static_cast<int>(recording_.frames.size()); }
  const PinholeCamera& camera() const override { return camera_.pinhole; }
  const Calibration& calibration() const override { return recording_.calibration; }
  double rate_hz() const override { return rate_hz_; }
  std::int64_t stamp_ns(int index) const override { return frame(index).stamp_ns; }
  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    return frame(index).world_from_cam;
  }
  std::optional<Eigen::Vector3d> gravity_in_world() const override {
    return recording_.gravity_in_world;
  }
  std::optional<Eigen::Vector4d> floor_in_world() const override {
    return floor_ ? std::optional(floor_->floor_in_world) : std::nullopt;
  }
  double floor_std_m() const override { return floor_ ? floor_->std_m : 0; }

  Result<cv::Mat> ReadRawImage(int index) const override {
    return recording_.read_image(frame(index).item);
  }
  Result<Frame> ReadFrame(int index) const override {
    Result<cv::Mat> raw = ReadRawImage(index);
    if (!raw.ok()) return raw.error();
    return Frame{index, stamp_ns(index), undistorter_.Undistort(*raw), world_from_cam(index)};
  }
  Result<std::optional<cv::Mat>> ReadDepth(int index) const override {
    if (!recording_.read_depth) return std::optional<cv::Mat>();
    Result<std::optional<cv::Mat>> depth = recording_.read_depth(frame(index).item);
    if (!depth.ok()) return Error{ErrorCode::kCorrupt, depth.error().message};
    if (!depth->has_value()) return std::optional<cv::Mat>();
    return std::optional(undistorter_.UndistortNearest(**depth));
  }
  Result<std::optional<EdgeMap>> ReadEdges(int) const override { return std::optional<EdgeMap>(); }
  Result<std::optional<std::vector<Detection>>> ReadProposals(int index) const override {
    if (!recording_.read_proposals) return std::optional<std::vector<Detection>>();
    auto proposals = recording_.read_proposals(frame(index).item);
    if (!proposals.ok()) return Error{ErrorCode::kCorrupt, proposals.error().message};
    if (proposals->has_value()) {
      for (Detection& proposal : **proposals) proposal.box = UndistortBox(camera_, proposal.box);
      if (!camera_.distortion.empty())
        std::erase_if(**proposals, [](const Detection& proposal) { return proposal.box.empty(); });
    }
    return proposals;
  }
  Result<ImuRecording> ReadImu() const override {
    return recording_.read_imu ? recording_.read_imu() : ImuRecording();
  }
  bool has_images() const override { return true; }
  bool has_imu() const override { return static_cast<bool>(recording_.read_imu); }
  bool has_depth() const override { return static_cast<bool>(recording_.read_depth); }
  bool has_edges() const override { return false; }
  bool has_proposals() const override { return static_cast<bool>(recording_.read_proposals); }
  std::optional<fs::path> scene_file() const override { return recording_.scene_file; }
  std::optional<fs::path> ground_truth_file() const override { return std::nullopt; }
  std::optional<fs::path> models_folder() const override { return recording_.models_folder; }
  std::optional<fs::path> tracks_file() const override { return std::nullopt; }
  std::optional<fs::path> reference_file() const override { return std::nullopt; }
  const std::vector<std::string>& warnings() const override { return recording_.warnings; }

 private:
  const RecordedFrame& frame(int index) const {
    PLB_CHECK(index >= 0 && index < num_frames()) << "frame " << index << " of " << num_frames();
    return recording_.frames[static_cast<std::size_t>(index)];
  }

  Recording recording_;
  const Camera& camera_ = recording_.calibration.cameras.front().camera;
  Undistorter undistorter_;
  double rate_hz_;
  std::optional<PathFloor> floor_;
};

}  // namespace

Result<std::shared_ptr<const Sequence>> MakeSequence(Recording recording,
                                                     const SequenceOptions& options) {
  PLB_CHECK(!recording.calibration.cameras.empty() && recording.read_image)
      << "a recording has a camera and images";
  std::vector<RecordedFrame>& frames = recording.frames;
  if (frames.empty()) {
    return Error{ErrorCode::kCorrupt, "'" + recording.path.string() + "' has no frame"};
  }
  MakeStampsRise(recording.path, "frames", frames, recording.warnings);
  std::vector<std::int64_t> stamps;
  for (const RecordedFrame& frame : frames) stamps.push_back(frame.stamp_ns);
  const Camera& camera = recording.calibration.cameras.front().camera;
  const double measured = StatisticsOf(stamps, 1.5).rate_hz();
  const double rate_hz = measured > 0 ? measured : camera.rate_hz;
  if (!options.poses.empty()) {
    const Result<Trajectory> given = ReadTrajectory(options.poses, camera.body_from_cam);
    if (!given.ok()) return given.error();
    recording.warnings.insert(recording.warnings.end(), given->warnings.begin(),
                              given->warnings.end());
    for (RecordedFrame& frame : frames)
      frame.world_from_cam =
          given->Nearest(frame.stamp_ns, static_cast<std::int64_t>(0.5e9 / rate_hz));
  }
  return std::shared_ptr<const Sequence>(
      std::make_shared<RecordedSequence>(std::move(recording), rate_hz));
}

std::optional<Eigen::Isometry3d> PoseAt(const Trajectory& trajectory, std::int64_t stamp_ns,
                                        std::int64_t step_ns) {
  const auto after = std::lower_bound(
      trajectory.poses.begin(), trajectory.poses.end(), stamp_ns,
      [](const StampedPose& pose, std::int64_t stamp) { return pose.stamp_ns < stamp; });
  if (after == trajectory.poses.begin() || after == trajectory.poses.end() ||
      after->stamp_ns - std::prev(after)->stamp_ns > step_ns)
    return trajectory.Nearest(stamp_ns, step_ns / 2);
  const StampedPose &a = *std::prev(after), &b = *after;
  const double share =
      static_cast<double>(stamp_ns - a.stamp_ns) / static_cast<double>(b.stamp_ns - a.stamp_ns);
  const Eigen::Quaterniond from(a.world_from_cam.linear()), to(b.world_from_cam.linear());
  Eigen::Isometry3d between(from.slerp(share, to));
  between.translation() =
      (1 - share) * a.world_from_cam.translation() + share * b.world_from_cam.translation();
  return between;
}

Result<Camera> MakeCamera(const PinholeCamera& pinhole, double rate_hz, const fs::path& file) {
  nlohmann::json json = IntrinsicsToJson(pinhole);
  json["model"] = "pinhole";
  json["rate_hz"] = rate_hz;
  return CameraFromJson(json, file);
}

cv::Mat InMillimetres(const cv::Mat& raw, double units_per_metre) {
  const double mm_per_unit = 1000 / units_per_metre;
  cv::Mat depth(raw.size(), CV_16UC1);
  for (int y = 0; y < raw.rows; ++y) {
    const auto* from = raw.ptr<std::uint16_t>(y);
    auto* to = depth.ptr<std::uint16_t>(y);
    for (int x = 0; x < raw.cols; ++x) {
      const double mm = std::round(from[x] * mm_per_unit);
      to[x] = mm < 65536 ? static_cast<std::uint16_t>(mm) : 0;
    }
  }
  return depth;
}

Result<cv::Mat> DepthFromFile(const fs::path& file, cv::Size size, double units_per_metre) {
  const Result<cv::Mat> raw = ReadImage(file, ImageKind::kDepth, size);
  if (!raw.ok() || units_per_metre == 1000) return raw;
  return InMillimetres(*raw, units_per_metre);
}

cv::Mat SeenBy(const PinholeCamera& target, const PinholeCamera& source, const cv::Mat& depth) {
  const auto beyond = [](double pixel, int size) { return !(pixel > -0.5 && pixel < size - 0.5); };
  cv::Mat seen(target.height, target.width, CV_16UC1, cv::Scalar(0));
  for (int y = 0; y < target.height; ++y) {
    const double row = source.fy * (y - target.cy) / target.fy + source.cy;
    if (beyond(row, depth.rows)) continue;
    const auto* from = depth.ptr<std::uint16_t>(static_cast<int>(std::lround(row)));
    for (int x = 0; x < target.width; ++x) {
      const double column = source.fx * (x - target.cx) / target.fx + source.cx;
      if (!beyond(column, depth.cols)) seen.at<std::uint16_t>(y, x) = from[std::lround(column)];
    }
  }
  return seen;
}

double NanosecondsPerUnit(const std::vector<std::uint64_t>& stamps) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i)
    steps.push_back(static_cast<double>(stamps[i] - stamps[i - 1]));
  if (steps.empty()) return 1;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  for (const double ns : {1.0, 1e3, 1e6, 1e9}) {
    if (*middle * ns > 2e6 && *middle * ns < 5e9) return ns;
  }
  return 1;
}

bool IsThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    names.push_back(entry->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::optional<int> NumberInName(std::string_view name, std::string_view prefix,
                                std::string_view ending) {
  if (name.size() <= prefix.size() + ending.size() || !name.starts_with(prefix) ||
      !name.ends_with(ending))
    return std::nullopt;
  name.remove_prefix(prefix.size());
  name.remove_suffix(ending.size());
  int number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc() || end != name.data() + name.size() || number < 0) return std::nullopt;
  return number;
}

}  // namespace plumbline
