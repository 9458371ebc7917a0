// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/icl_nuim_sequence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "engine/dataset/recorded_sequence.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr PinholeCamera kIclCamera = {640, 480, 481.20, 480.00, 319.50, 239.50};
constexpr double kIclUnitsPerMetre = 5000;

fs::path IclTruthFile(const fs::path& folder) {
  for (const std::string& name : NamesIn(folder)) {
    if (name.ends_with(".gt.freiburg")) return folder / name;
  }
  return {};
}

fs::path IclImage(const fs::path& folder, const char* kind, std::size_t number) {
  return folder / kind / (std::to_string(number) + ".png");
}

/// By the number of the image.
std::map<std::size_t, Eigen::Isometry3d> PosesByNumber(const Trajectory& trajectory) {
  const Eigen::Matrix3d mirror = Eigen::Vector3d(1, -1, 1).asDiagonal();
  std::map<std::size_t, Eigen::Isometry3d> poses;
  for (const StampedPose& row : trajectory.poses) {
    if (row.stamp_ns < 0) continue;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = mirror * row.world_from_cam.linear() * mirror;
    pose.translation() = mirror * row.world_from_cam.translation();
    // A number is read as if it were seconds.
    poses[static_cast<std::size_t>(row.stamp_ns / 1'000'000'000)] = pose;
  }
  return poses;
}

}  // namespace

Likeness ProbeIclNuim(const fs::path& path) {
  return IsThere(path / "rgb") && !IclTruthFile(path).empty() ? Likeness::kCertain
                                                              : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenIclNuim(const fs::path& folder,
                                                    const SequenceOptions& options) {
  const fs::path truth = IclTruthFile(folder);
  const Result<Trajectory> trajectory = ReadTrajectory(truth, std::nullopt);
  if (!trajectory.ok()) return trajectory.error();
  const Result<Camera> camera = MakeCamera(kIclCamera, 30, folder);
  if (!camera.ok()) return camera.error();
  Recording recording;
  recording.path = folder;
  recording.calibration.cameras = {{"cam", *camera}};
  recording.warnings = trajectory->warnings;
  recording.gravity_in_world = Eigen::Vector3d(0, 1, 0);
  const std::map<std::size_t, Eigen::Isometry3d> poses = PosesByNumber(*trajectory);
  for (const std::string& name : NamesIn(folder / "rgb")) {
    const std::optional<int> number = NumberInName(name, "", ".png");
    if (!number) continue;
    RecordedFrame frame{std::llround(*number * (1e9 / 30)), static_cast<std::size_t>(*number),
                        std::nullopt};
    if (const auto pose = poses.find(frame.item); pose != poses.end())
      frame.world_from_cam = pose->second;
    recording.frames.push_back(frame);
  }
  // By number, not by name: 10.png comes after 9.png.
  std::sort(recording.frames.begin(), recording.frames.end(),
            [](const RecordedFrame& a, const RecordedFrame& b) { return a.item < b.item; });
  const cv::Size size(kIclCamera.width, kIclCamera.height);
  recording.read_image = [folder, size](std::size_t number) {
    return ReadImage(IclImage(folder, "rgb", number), ImageKind::kColor, size);
  };
  if (IsThere(folder / "depth")) {
    recording.read_depth = [folder, size](std::size_t number) -> Result<std::optional<cv::Mat>> {
      const fs::path file = IclImage(folder, "depth", number);
      if (!IsThere(file)) return std::optional<cv::Mat>();
      Result<cv::Mat> depth = DepthFromFile(file, size, kIclUnitsPerMetre);
      if (!depth.ok()) return depth.error();
      return std::optional(std::move(*depth));
    };
  }
  return MakeSequence(std::move(recording), options);
}

}  // namespace plumbline
