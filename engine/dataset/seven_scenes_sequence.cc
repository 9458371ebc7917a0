// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/seven_scenes_sequence.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <utility>

#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/rigid_matrix.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr PinholeCamera kKinectOfSevenScenes = {640, 480, 585, 585, 320, 240};
constexpr double kSevenScenesRate_hz = 30;
constexpr std::uint16_t kNoDepthOfSevenScenes = 65535;

fs::path SevenScenesFile(const fs::path& folder, std::size_t number, const char* ending) {
  char name[40];
  std::snprintf(name, sizeof name, "frame-%06zu%s", number, ending);
  return folder / name;
}

bool NamesFrameOfSevenScenes(const std::string& name) {
  return NumberInName(name, "frame-", ".color.png").has_value();
}

/// The parts seq-NN among the names of a scene's folder.
std::vector<std::string> PartsOfSevenScenes(const fs::path& scene, std::vector<std::string> names) {
  std::erase_if(names, [&](const std::string& name) {
    return !name.starts_with("seq-") || !IsThere(SevenScenesFile(scene / name, 0, ".color.png"));
  });
  return names;
}

Result<std::optional<cv::Mat>> ReadSevenScenesDepth(const fs::path& file) {
  if (!IsThere(file)) return std::optional<cv::Mat>();
  Result<cv::Mat> depth =
      DepthFromFile(file, {kKinectOfSevenScenes.width, kKinectOfSevenScenes.height}, 1000);
  if (!depth.ok()) return depth.error();
  depth->setTo(0, *depth == kNoDepthOfSevenScenes);
  return std::optional(std::move(*depth));
}

/// Frames with their poses; what is odd goes into the warnings.
std::vector<RecordedFrame> FramesOfSevenScenes(const fs::path& folder,
                                               std::vector<std::string>& warnings) {
  std::vector<RecordedFrame> frames;
  std::string unusable;
  int without = 0;
  for (const std::string& name : NamesIn(folder)) {
    const std::optional<int> number = NumberInName(name, "frame-", ".color.png");
    if (!number) continue;
    RecordedFrame frame;
    frame.item = static_cast<std::size_t>(*number);
    frame.stamp_ns = static_cast<std::int64_t>(*number * (1e9 / kSevenScenesRate_hz));
    const fs::path file = SevenScenesFile(folder, frame.item, ".pose.txt");
    const Result<std::vector<double>> numbers = NumbersOf(file);
    if (numbers.ok() && numbers->size() == 16) frame.world_from_cam = RigidFromRows(*numbers);
    if (!frame.world_from_cam && without++ == 0) unusable = file.filename().string();
    frames.push_back(frame);
  }
  if (without > 0) {
    warnings.push_back("'" + folder.string() + "' has " + std::to_string(without) +
                       " frames without a rigid pose (such as '" + unusable + "')");
  }
  return frames;
}

}  // namespace

Likeness ProbeSevenScenes(const fs::path& path) {
  if (IsThere(SevenScenesFile(path, 0, ".color.png"))) return Likeness::kCertain;
  const std::vector<std::string> names = NamesIn(path);
  if (std::any_of(names.begin(), names.end(), NamesFrameOfSevenScenes)) return Likeness::kCertain;
  return PartsOfSevenScenes(path, names).empty() ? Likeness::kNone : Likeness::kPossible;
}

Result<std::shared_ptr<const Sequence>> OpenSevenScenes(const fs::path& folder,
                                                        const SequenceOptions& options) {
  if (const auto parts = PartsOfSevenScenes(folder, NamesIn(folder)); !parts.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + folder.string() + "' is a scene of 7-Scenes with " +
                     std::to_string(parts.size()) + " sequences; open one of them, such as '" +
                     (folder / parts.front()).string() + "'"};
  }
  const Result<Camera> camera = MakeCamera(kKinectOfSevenScenes, kSevenScenesRate_hz, folder);
  if (!camera.ok()) return camera.error();
  Recording recording;
  recording.path = folder;
  recording.calibration.cameras = {{"kinect", *camera}};
  recording.frames = FramesOfSevenScenes(folder, recording.warnings);
  const cv::Size size(kKinectOfSevenScenes.width, kKinectOfSevenScenes.height);
  recording.read_image = [folder, size](std::size_t number) {
    return ReadImage(SevenScenesFile(folder, number, ".color.png"), ImageKind::kColor, size);
  };
  if (std::any_of(recording.frames.begin(), recording.frames.end(), [&](const RecordedFrame& f) {
        return IsThere(SevenScenesFile(folder, f.item, ".depth.png"));
      })) {
    recording.read_depth = [folder](std::size_t number) {
      return ReadSevenScenesDepth(SevenScenesFile(folder, number, ".depth.png"));
    };
  }
  return MakeSequence(std::move(recording), options);
}

}  // namespace plumbline
