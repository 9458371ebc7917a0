// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/kitti_odometry_sequence.h"

#include <cmath>
#include <cstdio>
#include <utility>

#include "engine/base/files.h"
#include "engine/dataset/kitti_files.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/rigid_matrix.h"
#include "engine/dataset/text_table.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

fs::path OdometryImage(const fs::path& images, std::size_t number) {
  char name[24];
  std::snprintf(name, sizeof name, "%06zu.png", number);
  return images / name;
}

/// One pose a line; a line that is none leaves its frame without.
Status JoinOdometryPoses(const fs::path& file, const Eigen::Isometry3d& cam_from_cam0,
                         Recording& recording) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  const std::vector<std::string_view> lines = SplitLines(*text);
  LineWarnings odd(file.string());
  for (RecordedFrame& frame : recording.frames) {
    if (frame.item >= lines.size()) continue;
    std::vector<double> numbers;
    for (const std::string_view field : SplitFields(lines[frame.item]))
      numbers.push_back(ParseNumber(field).value_or(std::nan("")));
    const auto pose = numbers.size() == 12 ? RigidFromRows(numbers) : std::nullopt;
    if (!pose) odd.Add("not the 12 numbers of a rigid transform; left out", frame.item + 1);
    if (pose) frame.world_from_cam = *pose * cam_from_cam0.inverse();
  }
  for (std::string& sentence : odd.Sentences()) recording.warnings.push_back(std::move(sentence));
  return {};
}

}  // namespace

Likeness ProbeKittiOdometry(const fs::path& path) {
  return IsThere(path / "calib.txt") && IsThere(path / "times.txt") &&
                 (IsThere(path / "image_2") || IsThere(path / "image_0"))
             ? Likeness::kCertain
             : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenKittiOdometry(const fs::path& folder,
                                                          const SequenceOptions& options) {
  const bool color = IsThere(folder / "image_2");
  const fs::path images = folder / (color ? "image_2" : "image_0");
  const fs::path calibration_file = folder / "calib.txt", times_file = folder / "times.txt";
  const Result<KittiCalibration> calibration = ParseKittiCalibration(calibration_file);
  if (!calibration.ok()) return calibration.error();
  const char* key = color ? "P2" : "P0";
  const auto projection = calibration->find(key);
  if (projection == calibration->end())
    return Error{ErrorCode::kCorrupt,
                 "'" + calibration_file.string() + "' has no line '" + std::string(key) + ": ..'"};
  const Result<std::string> times = ReadFile(times_file);
  if (!times.ok()) return times.error();
  Recording recording;
  recording.path = folder;
  LineWarnings odd(times_file.string());
  const std::vector<std::string_view> lines = SplitLines(*times);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<std::string_view> fields = SplitFields(lines[i]);
    if (fields.empty()) continue;
    const std::optional<std::int64_t> stamp = ParseStampNs(fields[0]);
    if (!stamp) odd.Add("not a time in seconds; frame left out", i + 1);
    if (stamp) recording.frames.push_back({*stamp, i, std::nullopt});
  }
  for (std::string& sentence : odd.Sentences()) recording.warnings.push_back(std::move(sentence));
  if (recording.frames.empty())
    return Error{ErrorCode::kCorrupt, "'" + times_file.string() + "' has no time"};
  // The size is told nowhere else, and differs from sequence to sequence.
  const Result<cv::Mat> first =
      ReadImage(OdometryImage(images, recording.frames.front().item), ImageKind::kColor);
  if (!first.ok()) return first.error();
  const Result<KittiCamera> camera =
      CameraFromProjection(projection->second, first->cols, first->rows, calibration_file);
  if (!camera.ok()) return camera.error();
  recording.calibration.cameras = {{images.filename().string(), camera->camera}};
  recording.read_image = [images, size = first->size()](std::size_t number) {
    return ReadImage(OdometryImage(images, number), ImageKind::kColor, size);
  };
  const fs::path whole = fs::absolute(folder).lexically_normal();
  const fs::path named = whole.has_filename() ? whole : whole.parent_path();
  const fs::path poses =
      named.parent_path().parent_path() / "poses" / (named.filename().string() + ".txt");
  if (IsThere(poses)) {
    if (Status joined = JoinOdometryPoses(poses, camera->cam_from_cam0, recording); !joined.ok())
      return joined.error();
  }
  return MakeSequence(std::move(recording), options);
}

}  // namespace plumbline
