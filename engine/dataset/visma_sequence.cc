// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/visma_sequence.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/rigid_matrix.h"
#include "engine/dataset/visma_dataset.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

struct VismaImage {
  std::uint64_t number = 0;  ///< The whole part of its name.
  std::string stem;
};

/// In time order: by the number, which as a float would lose its end.
std::vector<VismaImage> ImagesOfVisma(const fs::path& folder) {
  std::vector<VismaImage> images;
  for (const std::string& name : NamesIn(folder)) {
    if (!name.ends_with(".png")) continue;
    VismaImage image{0, name.substr(0, name.size() - 4)};
    const char* begin = image.stem.data();
    const char* end = begin + image.stem.size();
    const auto [rest, error] = std::from_chars(begin, end, image.number);
    if (error == std::errc() && (rest == end || *rest == '.') && image.number < 1ull << 62)
      images.push_back(std::move(image));
  }
  std::stable_sort(images.begin(), images.end(),
                   [](const VismaImage& a, const VismaImage& b) { return a.number < b.number; });
  return images;
}

/// VISMA's categories by a word of the model's name.
std::string CategoryOfVisma(const std::string& model) {
  constexpr std::pair<std::string_view, std::string_view> kWords[] = {
      {"chair", "chair"},       {"aeron", "chair"},        {"couch", "couch"}, {"sofa", "couch"},
      {"desk", "dining table"}, {"table", "dining table"}, {"bed", "bed"},     {"tv", "tv"},
      {"monitor", "tv"},        {"bowl", "bowl"},          {"cup", "cup"}};
  for (const auto& [word, category] : kWords) {
    if (model.find(word) != std::string::npos) return std::string(category);
  }
  return "chair";
}

std::optional<Eigen::Isometry3d> RigidFromJsonRows(const nlohmann::json& json) {
  const auto numbers = VectorFromJson(json, 12);
  if (!numbers) return std::nullopt;
  return RigidFromRows({numbers->data(), 12});
}

/// The folder fragments of the sequence; empty without one.
fs::path FragmentsOf(const fs::path& folder) {
  fs::path whole = fs::absolute(folder).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  const fs::path above = whole.parent_path();
  for (const fs::path& place : {whole, above / "RGBD" / whole.filename(),
                                above.parent_path() / "RGBD" / whole.filename()}) {
    if (IsThere(place / "fragments" / "alignment.json")) return place / "fragments";
  }
  return {};
}

/// T_ef_corvis of result_alignment.json beside or above the fragments.
Result<std::optional<Eigen::Isometry3d>> ScanFromWorldOf(const fs::path& fragments) {
  for (const fs::path& place : {fragments, fragments.parent_path()}) {
    const fs::path file = place / "result_alignment.json";
    if (!IsThere(file)) continue;
    const Result<nlohmann::json> json = ReadJson(file);
    if (!json.ok()) return json.error();
    const auto rigid = json->is_object() && json->contains("T_ef_corvis")
                           ? RigidFromJsonRows((*json)["T_ef_corvis"])
                           : std::nullopt;
    if (!rigid)
      return Error{ErrorCode::kInvalidInput,
                   "'" + file.string() + "' has no rigid 'T_ef_corvis' of 12 numbers"};
    return rigid;
  }
  return std::optional<Eigen::Isometry3d>();
}

}  // namespace

Likeness ProbeVisma(const fs::path& path) {
  return IsThere(path / "dataset") && !ImagesOfVisma(path).empty() ? Likeness::kCertain
                                                                   : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenVisma(const fs::path& folder,
                                                  const SequenceOptions& options) {
  const fs::path file = folder / "dataset";
  const Result<VismaDataset> dataset = ReadVismaDataset(file);
  if (!dataset.ok()) return dataset.error();
  const std::vector<double>& k = dataset->parameters;
  if (k.size() < 4)
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' has a camera of less than four parameters"};
  const Result<Camera> camera =
      MakeCamera({dataset->cols, dataset->rows, k[0], k[1], k[2], k[3]}, 30, file);
  if (!camera.ok()) return camera.error();
  Recording recording;
  recording.path = folder;
  recording.calibration.cameras = {{"cam", *camera}};
  if (k.size() > 4)
    recording.warnings.push_back("'" + file.string() + "' has " + std::to_string(k.size() - 4) +
                                 " more parameters of its camera, which are not used");
  const std::vector<VismaImage> images = ImagesOfVisma(folder);
  const auto& packets = dataset->packets;
  if (images.size() != packets.size())
    recording.warnings.push_back("'" + folder.string() + "' has " + std::to_string(images.size()) +
                                 " images and " + std::to_string(packets.size()) +
                                 " packets; the first of each belong together");
  std::vector<std::uint64_t> numbers;
  for (const VismaImage& image : images) numbers.push_back(image.number);
  const double ns = NanosecondsPerUnit(numbers);
  for (std::size_t i = 0; i < images.size(); ++i) {
    RecordedFrame frame{std::llround(static_cast<double>(images[i].number - numbers.front()) * ns),
                        i, std::nullopt};
    // Whole nanoseconds stay whole.
    if (ns == 1) frame.stamp_ns = static_cast<std::int64_t>(images[i].number);
    if (i < packets.size()) frame.world_from_cam = packets[i].world_from_cam;
    recording.frames.push_back(frame);
  }
  for (const VismaDataset::Packet& packet : packets) {
    if (!packet.gravity_rotation) continue;
    const Eigen::Vector3d w(packet.gravity_rotation->x(), packet.gravity_rotation->y(), 0);
    const Eigen::Matrix3d turn =
        w.norm() > 0 ? Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix()
                     : Eigen::Matrix3d::Identity().eval();
    recording.gravity_in_world = turn * Eigen::Vector3d(0, 0, -1);
  }
  const cv::Size size(dataset->cols, dataset->rows);
  recording.read_image = [folder, images, size](std::size_t item) {
    return ReadImage(folder / (images[item].stem + ".png"), ImageKind::kColor, size);
  };
  if (!images.empty() && IsThere(folder / (images.front().stem + ".bbox"))) {
    recording.read_proposals =
        [folder, images](std::size_t item) -> Result<std::optional<std::vector<Detection>>> {
      const fs::path boxes_file = folder / (images[item].stem + ".bbox");
      if (!IsThere(boxes_file)) return std::optional<std::vector<Detection>>();
      Result<std::vector<Detection>> boxes = ReadVismaBoxes(boxes_file);
      if (!boxes.ok()) return boxes.error();
      return std::optional(std::move(*boxes));
    };
  }
  return MakeSequence(std::move(recording), options);
}

Result<GroundTruth> ReadVismaTruth(const fs::path& fragments, const ModelFrames& models,
                                   std::vector<std::string>& warnings) {
  const fs::path file = fragments / "alignment.json", list = fragments / "objects.json";
  const Result<nlohmann::json> alignment = ReadJson(file);
  if (!alignment.ok()) return alignment.error();
  if (!alignment->is_object())
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' is no object of alignments"};
  std::vector<std::string> entries;
  if (IsThere(list)) {
    const Result<nlohmann::json> objects = ReadJson(list);
    if (!objects.ok()) return objects.error();
    if (!objects->is_object() || !objects->contains("entries") || !(*objects)["entries"].is_array())
      return Error{ErrorCode::kInvalidInput, "'" + list.string() + "' has no list 'entries'"};
    for (const nlohmann::json& entry : (*objects)["entries"]) {
      if (entry.is_string()) entries.push_back(entry.get<std::string>());
    }
  } else {
    for (const auto& [name, value] : alignment->items()) entries.push_back(name);
  }
  GroundTruth truth;
  // What is z up of ours is y up of theirs.
  Eigen::Isometry3d object_from_file = Eigen::Isometry3d::Identity();
  object_from_file.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  std::vector<std::string> seen;
  for (const std::string& entry : entries) {
    const auto pose =
        alignment->contains(entry) ? RigidFromJsonRows((*alignment)[entry]) : std::nullopt;
    const bool again = std::find(seen.begin(), seen.end(), entry) != seen.end();
    seen.push_back(entry);
    if (!pose || again) {
      warnings.push_back("'" + file.string() + "' has no rigid transform of 12 numbers for '" +
                         entry + "'; left out");
      continue;
    }
    GroundTruthInstance instance;
    instance.id = entry;
    instance.model = entry.substr(0, entry.rfind('_'));
    instance.category = CategoryOfVisma(instance.model);
    const Eigen::Isometry3d* built = FindModelFrame(models, instance.model, warnings);
    instance.world_from_object = *pose * (built ? *built : object_from_file).inverse();
    up += instance.world_from_object.linear().col(2);
    truth.instances.push_back(std::move(instance));
  }
  if (truth.instances.empty() || !(up.norm() > 0.1))
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' aligns no object of objects.json"};
  truth.gravity_in_world = -up.normalized();
  return truth;
}

Result<std::optional<GroundTruth>> TruthOfVisma(const Sequence& sequence, const ModelFrames& models,
                                                std::vector<std::string>& warnings) {
  const fs::path fragments = FragmentsOf(sequence.path());
  if (fragments.empty()) return std::optional<GroundTruth>();
  Result<GroundTruth> truth = ReadVismaTruth(fragments, models, warnings);
  if (!truth.ok()) return truth.error();
  const Result<std::optional<Eigen::Isometry3d>> scan_from_world = ScanFromWorldOf(fragments);
  if (!scan_from_world.ok()) return scan_from_world.error();
  if (!scan_from_world->has_value()) {
    warnings.push_back(
        "there is no result_alignment.json beside '" + fragments.string() +
        "': the ground truth is in the frame of the scan, not of the sequence (evaluate --align)");
    return std::optional(std::move(*truth));
  }
  const Eigen::Isometry3d world_from_scan = (*scan_from_world)->inverse();
  for (GroundTruthInstance& instance : truth->instances)
    instance.world_from_object = world_from_scan * instance.world_from_object;
  truth->gravity_in_world = world_from_scan.linear() * truth->gravity_in_world;
  if (const auto gravity = sequence.gravity_in_world()) {
    constexpr double kFiveDegrees = 0.9962;
    if (gravity->dot(truth->gravity_in_world) < kFiveDegrees)
      warnings.push_back("'" + (sequence.path() / "dataset").string() +
                         "' tells a gravity more than 5 degrees off the up axes of the aligned "
                         "models; check it against the floor (plumbline gravity)");
  }
  return std::optional(std::move(*truth));
}

}  // namespace plumbline
