// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/tum_rgbd_sequence.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/data_paths.h"
#include "engine/base/files.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/rigid_matrix.h"
#include "engine/dataset/sequence_writing.h"
#include "engine/dataset/stamped_rows.h"
#include "engine/dataset/text_table.h"
#include "engine/dataset/trajectory_writer.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr double kTumUnitsPerMetre = 5000;
constexpr std::int64_t kTumDepthWithin_ns = 20'000'000;
constexpr std::int64_t kTumPoseStep_ns = 30'000'000;  ///< Motion capture comes at 100 Hz.

struct TumImage {
  std::int64_t stamp_ns = 0;
  fs::path file;
};

/// Rows `stamp file`.
Result<std::vector<TumImage>> ReadTumList(const fs::path& file,
                                          std::vector<std::string>& warnings) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  std::vector<TumImage> images;
  LineWarnings odd(file.string());
  std::size_t number = 0;
  for (const std::string_view line : SplitLines(*text)) {
    ++number;
    const std::vector<std::string_view> fields = SplitFields(line);
    if (fields.empty() || fields[0].starts_with('#')) continue;
    const auto stamp = ParseStampNs(fields[0]);
    if (fields.size() != 2 || !stamp) {
      odd.Add("not a stamp and the name of an image; row left out", number);
      continue;
    }
    const Result<fs::path> place = PlaceInside(file.parent_path(), std::string(fields[1]));
    if (!place.ok()) {
      odd.Add("the image lies outside of the folder (--allow-outside reads it); row left out",
              number);
      continue;
    }
    images.push_back({*stamp, *place});
  }
  for (std::string& sentence : odd.Sentences()) warnings.push_back(std::move(sentence));
  MakeStampsRise(file, "images", images, warnings);
  if (images.empty()) return Error{ErrorCode::kCorrupt, "'" + file.string() + "' lists no image"};
  return images;
}

/// The depth image nearest in time, if it is near.
const TumImage* NearestDepth(const std::vector<TumImage>& depths, std::int64_t stamp_ns) {
  const TumImage* best = nullptr;
  const auto after =
      std::lower_bound(depths.begin(), depths.end(), stamp_ns,
                       [](const TumImage& image, std::int64_t t) { return image.stamp_ns < t; });
  if (after != depths.end()) best = &*after;
  if (after != depths.begin() &&
      (best == nullptr || stamp_ns - std::prev(after)->stamp_ns <= best->stamp_ns - stamp_ns))
    best = &*std::prev(after);
  return best != nullptr && std::abs(best->stamp_ns - stamp_ns) <= kTumDepthWithin_ns ? best
                                                                                      : nullptr;
}

/// The colour cameras of the benchmark's page, by a part of the folder's name.
struct NamedKinect {
  std::string_view name;
  PinholeCamera pinhole;
  std::array<double, 5> distortion;  ///< k1 k2 p1 p2 k3.
};
constexpr NamedKinect kTumCameras[] = {
    {"freiburg1",
     {640, 480, 517.3, 516.5, 318.6, 255.3},
     {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}},
    {"freiburg2",
     {640, 480, 520.9, 521.0, 325.1, 249.7},
     {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}},
    {"freiburg3", {640, 480, 535.4, 539.2, 320.1, 247.6}, {0, 0, 0, 0, 0}},
    {"", {640, 480, 525, 525, 319.5, 239.5}, {0, 0, 0, 0, 0}}};

Result<Camera> TumCamera(const fs::path& folder, const fs::path& first_image) {
  if (const fs::path file = folder / "calibration.txt"; IsThere(file)) {
    const Result<std::vector<double>> numbers = NumbersOf(file);
    if (!numbers.ok()) return numbers.error();
    if (numbers->size() != 4) {
      return Error{ErrorCode::kCorrupt, "'" + file.string() +
                                            "' does not hold the four numbers fx fy cx cy of a "
                                            "camera without distortion"};
    }
    const Result<cv::Mat> image = ReadImage(first_image, ImageKind::kColor);
    if (!image.ok()) return image.error();
    const std::vector<double>& n = *numbers;
    return MakeCamera({image->cols, image->rows, n[0], n[1], n[2], n[3]}, 30, file);
  }
  const std::string name = fs::absolute(folder).lexically_normal().string();
  for (const NamedKinect& kinect : kTumCameras) {
    if (name.find(kinect.name) == std::string::npos) continue;
    nlohmann::json json = IntrinsicsToJson(kinect.pinhole);
    const bool straight = kinect.distortion[0] == 0;
    json["model"] = straight ? "pinhole" : "radial_tangential";
    if (!straight) json["distortion"] = kinect.distortion;
    json["rate_hz"] = 30;
    return CameraFromJson(json, folder);
  }
  return Error{ErrorCode::kInvalidInput, "no camera"};  // the last name is part of all
}

}  // namespace

Likeness ProbeTumRgbd(const fs::path& path) {
  return IsThere(path / "rgb.txt") ? Likeness::kCertain : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenTumRgbd(const fs::path& folder,
                                                    const SequenceOptions& options) {
  Recording recording;
  recording.path = folder;
  const Result<std::vector<TumImage>> images = ReadTumList(folder / "rgb.txt", recording.warnings);
  if (!images.ok()) return images.error();
  const Result<Camera> camera = TumCamera(folder, images->front().file);
  if (!camera.ok()) return camera.error();
  recording.calibration.cameras = {{"kinect", *camera}};
  for (std::size_t i = 0; i < images->size(); ++i)
    recording.frames.push_back({(*images)[i].stamp_ns, i, std::nullopt});
  const cv::Size size(camera->pinhole.width, camera->pinhole.height);
  recording.read_image = [images = *images, size](std::size_t item) {
    return ReadImage(images[item].file, ImageKind::kColor, size);
  };
  if (const fs::path list = folder / "depth.txt"; IsThere(list)) {
    const Result<std::vector<TumImage>> depths = ReadTumList(list, recording.warnings);
    if (!depths.ok()) return depths.error();
    recording.read_depth = [images = *images, depths = *depths,
                            size](std::size_t item) -> Result<std::optional<cv::Mat>> {
      const TumImage* depth = NearestDepth(depths, images[item].stamp_ns);
      if (depth == nullptr) return std::optional<cv::Mat>();
      Result<cv::Mat> read = DepthFromFile(depth->file, size, kTumUnitsPerMetre);
      if (!read.ok()) return read.error();
      return std::optional(std::move(*read));
    };
  }
  if (const fs::path file = folder / "groundtruth.txt"; IsThere(file)) {
    const Result<Trajectory> poses = ReadTrajectory(file, std::nullopt);
    if (!poses.ok()) return poses.error();
    recording.warnings.insert(recording.warnings.end(), poses->warnings.begin(),
                              poses->warnings.end());
    for (RecordedFrame& frame : recording.frames)
      frame.world_from_cam = PoseAt(*poses, frame.stamp_ns, kTumPoseStep_ns);
    recording.gravity_in_world = Eigen::Vector3d(0, 0, -1);
  }
  return MakeSequence(std::move(recording), options);
}

Result<WrittenSequence> WriteTumRgbd(const Sequence& sequence, const fs::path& folder,
                                     const WriteOptions& options, const WorkContext& context) {
  if (Status made = MakeFolderFor(folder, {"rgb", "depth"}); !made.ok()) return made.error();
  std::string images = "# color images\n# timestamp filename\n",
              depths = "# depth maps\n# timestamp filename\n";
  std::vector<WrittenPose> poses;
  auto written =
      WriteImages(sequence, {folder / "rgb", folder / "depth", kTumUnitsPerMetre, true}, options,
                  context, [&](int index, const std::string& image, const std::string& depth) {
                    const std::string stamp = StampText(sequence.stamp_ns(index));
                    images += stamp + " rgb/" + image + "\n";
                    if (!depth.empty()) depths += stamp + " depth/" + depth + "\n";
                    if (const auto pose = sequence.world_from_cam(index))
                      poses.push_back({sequence.stamp_ns(index), *pose, PoseCovariance::Zero()});
                  });
  if (!written.ok()) return written;
  const PinholeCamera& c = sequence.camera();
  char camera[200];
  std::snprintf(camera, sizeof camera, "%.9g %.9g %.9g %.9g\n", c.fx, c.fy, c.cx, c.cy);
  Status status = WriteFileAtomically(folder / "rgb.txt", images);
  if (status.ok()) status = WriteFileAtomically(folder / "calibration.txt", camera);
  if (status.ok() && written->depth_images > 0)
    status = WriteFileAtomically(folder / "depth.txt", depths);
  if (status.ok() && !poses.empty())
    status = WriteTrajectory(folder / "groundtruth.txt", "world_from_cam", poses);
  if (!status.ok()) return status.error();
  written->poses = static_cast<int>(poses.size());
  return written;
}

}  // namespace plumbline
