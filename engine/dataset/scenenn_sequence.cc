// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/scenenn_sequence.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include <tinyxml2.h>

#include "engine/base/files.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/rigid_matrix.h"
#include "engine/dataset/text_table.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr PinholeCamera kSceneNnCamera = {640, 480, 544.47329, 544.47329, 320, 240};

fs::path NamedSceneNn(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

fs::path SceneNnTrajectory(const fs::path& folder) {
  if (IsThere(folder / "trajectory.log")) return folder / "trajectory.log";
  const fs::path scene = NamedSceneNn(folder);
  return scene.parent_path() / "trajectory" / (scene.filename().string() + "_trajectory.log");
}

fs::path SceneNnFile(const fs::path& folder, const char* kind, std::size_t number) {
  char name[40];
  std::snprintf(name, sizeof name, "%s%05zu.png", kind, number);
  return folder / kind / name;
}

/// The poses of a Redwood log, one after the other; a matrix that is none leaves its place empty.
Result<std::vector<std::optional<Eigen::Isometry3d>>> PosesOfLog(const fs::path& file) {
  const Result<std::vector<double>> numbers = NumbersOf(file);
  if (!numbers.ok()) return numbers.error();
  constexpr std::size_t kEntry = 3 + 16;
  if (numbers->size() % kEntry != 0) {
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' is truncated: a pose is three numbers and a 4x4 matrix"};
  }
  std::vector<std::optional<Eigen::Isometry3d>> poses;
  for (std::size_t at = 0; at < numbers->size(); at += kEntry)
    poses.push_back(RigidFromRows({numbers->data() + at + 3, 16}));
  return poses;
}

/// Microseconds of colour images by their number.
Result<std::map<std::size_t, std::int64_t>> SceneNnStamps(const fs::path& file,
                                                          std::vector<std::string>& warnings) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  std::map<std::size_t, std::int64_t> stamps;
  LineWarnings odd(file.string());
  std::size_t line_number = 0;
  for (const std::string_view line : SplitLines(*text)) {
    ++line_number;
    const std::vector<std::string_view> fields = SplitFields(line);
    if (fields.empty()) continue;
    const auto number = ParseNumber(fields[0]);
    const auto stamp = fields.size() == 3 ? ParseNumber(fields[1]) : std::nullopt;
    if (!number || !stamp || !(*number >= 1 && *number < 1e7) || !(*stamp >= 0 && *stamp < 9e15)) {
      odd.Add("not 'k color_ts depth_ts'; row left out", line_number);
      continue;
    }
    stamps[static_cast<std::size_t>(*number)] = std::llround(*stamp) * 1000;
  }
  for (std::string& sentence : odd.Sentences()) warnings.push_back(std::move(sentence));
  return stamps;
}

}  // namespace

Likeness ProbeSceneNn(const fs::path& path) {
  return IsThere(path / "image") && IsThere(SceneNnTrajectory(path)) ? Likeness::kCertain
                                                                     : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenSceneNn(const fs::path& folder,
                                                    const SequenceOptions& options) {
  const Result<Camera> camera = MakeCamera(kSceneNnCamera, 30, folder);
  if (!camera.ok()) return camera.error();
  const fs::path log = SceneNnTrajectory(folder);
  const auto poses = PosesOfLog(log);
  if (!poses.ok()) return poses.error();
  Recording recording;
  recording.path = folder;
  recording.calibration.cameras = {{"xtion", *camera}};
  std::map<std::size_t, std::int64_t> stamps;
  if (const fs::path file = folder / "timestamp.txt"; IsThere(file)) {
    auto read = SceneNnStamps(file, recording.warnings);
    if (!read.ok()) return read.error();
    stamps = std::move(*read);
  }
  int without = 0, untimed = 0;
  for (const std::string& name : NamesIn(folder / "image")) {
    const std::optional<int> number = NumberInName(name, "image", ".png");
    if (!number || *number < 1) continue;  // they are counted from 1
    RecordedFrame frame{std::llround((*number - 1) * (1e9 / 30)), static_cast<std::size_t>(*number),
                        std::nullopt};
    const auto stamp = stamps.find(frame.item);
    untimed += !stamps.empty() && stamp == stamps.end();
    if (!stamps.empty() && stamp == stamps.end()) continue;
    if (stamp != stamps.end()) frame.stamp_ns = stamp->second;
    if (frame.item <= poses->size()) frame.world_from_cam = (*poses)[frame.item - 1];
    without += !frame.world_from_cam.has_value();
    recording.frames.push_back(frame);
  }
  if (without > 0)
    recording.warnings.push_back("'" + log.string() + "' has no rigid pose for " +
                                 std::to_string(without) + " images");
  if (untimed > 0)
    recording.warnings.push_back("'" + (folder / "timestamp.txt").string() + "' has no row for " +
                                 std::to_string(untimed) + " images; left out");
  const cv::Size size(kSceneNnCamera.width, kSceneNnCamera.height);
  recording.read_image = [folder, size](std::size_t number) {
    return ReadImage(SceneNnFile(folder, "image", number), ImageKind::kColor, size);
  };
  if (IsThere(folder / "depth")) {
    recording.read_depth = [folder, size](std::size_t number) -> Result<std::optional<cv::Mat>> {
      const fs::path file = SceneNnFile(folder, "depth", number);
      if (!IsThere(file)) return std::optional<cv::Mat>();
      Result<cv::Mat> depth = DepthFromFile(file, size, 1000);
      if (!depth.ok()) return depth.error();
      return std::optional(std::move(*depth));
    };
  }
  const fs::path mesh = folder / (NamedSceneNn(folder).filename().string() + ".ply");
  if (IsThere(mesh)) recording.scene_file = mesh;
  return MakeSequence(std::move(recording), options);
}

Result<std::vector<SceneNnLabel>> ReadSceneNnLabels(const fs::path& file) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' " + what};
  };
  tinyxml2::XMLDocument document;
  if (document.Parse(text->data(), text->size()) != tinyxml2::XML_SUCCESS)
    return bad("is not XML (line " + std::to_string(document.ErrorLineNum()) + ")");
  const tinyxml2::XMLElement* root = document.RootElement();
  if (root == nullptr) return bad("has no annotation");
  std::vector<SceneNnLabel> labels;
  for (const tinyxml2::XMLElement* label = root->FirstChildElement("label"); label != nullptr;
       label = label->NextSiblingElement("label")) {
    SceneNnLabel read;
    if (label->QueryIntAttribute("id", &read.id) != tinyxml2::XML_SUCCESS)
      return bad("has a label without a number (line " + std::to_string(label->GetLineNum()) + ")");
    if (const char* nyu = label->Attribute("nyu_class")) read.nyu_class = nyu;
    if (const char* name = label->Attribute("text")) read.text = name;
    labels.push_back(std::move(read));
  }
  if (labels.empty()) return bad("has no label");
  return labels;
}

std::optional<std::string> CategoryOfNyu(const std::string& nyu_class) {
  static const std::map<std::string, std::string> kCategories = {{"chair", "chair"},
                                                                 {"sofa", "couch"},
                                                                 {"table", "dining table"},
                                                                 {"desk", "dining table"},
                                                                 {"bed", "bed"},
                                                                 {"television", "tv"},
                                                                 {"monitor", "tv"},
                                                                 {"toilet", "toilet"},
                                                                 {"sink", "sink"},
                                                                 {"refrigerator", "refrigerator"},
                                                                 {"refridgerator", "refrigerator"}};
  const auto found = kCategories.find(nyu_class);
  return found == kCategories.end() ? std::nullopt : std::optional(found->second);
}

std::optional<fs::path> SceneNnAnnotation(const fs::path& folder) {
  const fs::path file = folder / (NamedSceneNn(folder).filename().string() + ".xml");
  return IsThere(file) ? std::optional(file) : std::nullopt;
}

}  // namespace plumbline
