// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/pose_exchange.h"

#include <map>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

constexpr double kManyMetres = 50;

Error NeedsSequence(const char* what) {
  return {ErrorCode::kInvalidInput, std::string(what) +
                                        " holds poses in cameras: the project needs a sequence "
                                        "(edit 'inputs') with camera poses"};
}

}  // namespace

std::optional<Eigen::Isometry3d> ScanFromCam(const AnnotationDocument& document,
                                             const Sequence& sequence, int frame) {
  const std::optional<Eigen::Isometry3d> world_from_cam = sequence.world_from_cam(frame);
  if (!world_from_cam) return std::nullopt;
  return document.scan_from_world.value_or(Eigen::Isometry3d::Identity()) * *world_from_cam;
}

std::optional<std::string> MetreWarning(const std::vector<Eigen::Vector3d>& translations,
                                        const std::string& file) {
  std::size_t far = 0;
  for (const Eigen::Vector3d& t : translations) far += t.norm() > kManyMetres;
  if (2 * far <= translations.size()) return std::nullopt;
  return "'" + file +
         "' should hold metres, but most of its objects are more than 50 m away: are "
         "these millimetres?";
}

Eigen::Isometry3d TargetFromScan(const AnnotationDocument& document, PoseFrame frame) {
  switch (frame) {
    case PoseFrame::kScan:
      break;
    case PoseFrame::kLevel:
      return document.LevelFromScan();
    case PoseFrame::kWorld:
      // Without an alignment both share a frame.
      if (document.scan_from_world) return document.scan_from_world->inverse();
      break;
  }
  return Eigen::Isometry3d::Identity();
}

GroundTruth GroundTruthOf(const AnnotationDocument& document, PoseFrame frame) {
  const Eigen::Isometry3d target_from_scan = TargetFromScan(document, frame);
  GroundTruth truth;
  truth.gravity_in_world = target_from_scan.linear() * document.gravity_in_scan;
  for (const AnnotatedInstance& instance : document.instances) {
    truth.instances.push_back({instance.id, instance.model, instance.category,
                               target_from_scan * instance.scan_from_object, instance.fine});
    truth.instances.back().scale = instance.scale;
  }
  return truth;
}

Status WriteGroundTruthOf(const AnnotationDocument& document, PoseFrame frame,
                          const std::filesystem::path& file) {
  return WriteGroundTruth(file, GroundTruthOf(document, frame));
}

Result<ImportedPoses> ReadGroundTruthPoses(const std::filesystem::path& file) {
  const Result<GroundTruth> truth = ReadGroundTruth(file);
  if (!truth) return truth.error();
  ImportedPoses imported;
  imported.gravity_in_scan = truth->gravity_in_world;
  std::vector<Eigen::Vector3d> translations;
  for (const GroundTruthInstance& entry : truth->instances) {
    AnnotatedInstance instance;
    instance.id = entry.id;
    instance.model = entry.model;
    instance.category = entry.category;
    instance.scan_from_object = entry.world_from_object;
    instance.fine = entry.fine;
    translations.push_back(entry.world_from_object.translation());
    instance.scale = entry.scale;
    imported.instances.push_back(std::move(instance));
  }
  if (auto warning = MetreWarning(translations, file.string())) {
    imported.warnings.push_back(std::move(*warning));
  }
  return imported;
}

Status WriteFramePoses(const AnnotationDocument& document, const ExchangeInputs& inputs,
                       const std::filesystem::path& file) {
  if (!inputs.sequence) return NeedsSequence("a file of per-frame poses");
  nlohmann::json json = {
      {"plumbline_frame_poses", 1},
      {"conventions",
       "metres; cam_from_object takes object coordinates (z up) to the camera (x right, y down, z "
       "forward), rows"},
      {"frames", nlohmann::json::array()}};
  for (const int frame : inputs.frames) {
    const auto scan_from_cam = ScanFromCam(document, *inputs.sequence, frame);
    if (!scan_from_cam) continue;
    const Eigen::Isometry3d cam_from_scan = scan_from_cam->inverse();
    nlohmann::json objects = nlohmann::json::array();
    for (const AnnotatedInstance& instance : document.instances) {
      objects.push_back(
          {{"id", instance.id},
           {"model", instance.model},
           {"category", instance.category},
           {"quality", instance.fine ? "fine" : "coarse"},
           {"cam_from_object", IsometryToJson(cam_from_scan * instance.scan_from_object)}});
      if (instance.scale != 1) objects.back()["scale"] = instance.scale;
    }
    json["frames"].push_back({{"frame", frame},
                              {"stamp_ns", inputs.sequence->stamp_ns(frame)},
                              {"objects", std::move(objects)}});
  }
  return WriteJson(file, json);
}

Result<ImportedPoses> ReadFramePoses(const AnnotationDocument& document,
                                     const ExchangeInputs& inputs,
                                     const std::filesystem::path& file) {
  if (!inputs.sequence) return NeedsSequence("a file of per-frame poses");
  const Result<nlohmann::json> json = ReadJson(file);
  if (!json) return json.error();
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' " + what};
  };
  if (!json->is_object() || !json->contains("frames") || !(*json)["frames"].is_array()) {
    return bad("has no list 'frames'");
  }
  ImportedPoses imported;
  std::map<std::string, std::size_t> known;
  std::vector<Eigen::Vector3d> translations;
  double worst_m = 0;
  for (const nlohmann::json& entry : (*json)["frames"]) {
    if (!entry.is_object() || !entry.contains("frame") || !entry["frame"].is_number_integer() ||
        (entry.contains("objects") && !entry["objects"].is_array())) {
      return bad("has an entry of 'frames' that is not {\"frame\": number, \"objects\": [..]}");
    }
    const auto frame = entry["frame"].get<std::int64_t>();
    if (frame < 0 || frame >= inputs.sequence->num_frames()) {
      return bad("names a frame that the sequence does not have");
    }
    const auto scan_from_cam = ScanFromCam(document, *inputs.sequence, static_cast<int>(frame));
    if (!scan_from_cam) continue;
    for (const nlohmann::json& object : entry.value("objects", nlohmann::json::array())) {
      const auto id = TextFromJson(object, "id"), model = TextFromJson(object, "model");
      const auto pose = object.is_object() && object.contains("cam_from_object")
                            ? IsometryFromJson(object["cam_from_object"])
                            : std::nullopt;
      if (!id || !model || !pose)
        return bad("has an object without id, model or rigid pose within 1000 km");
      translations.push_back(pose->translation());
      const Eigen::Isometry3d scan_from_object = *scan_from_cam * *pose;
      const auto [place, is_new] = known.emplace(*id, imported.instances.size());
      if (is_new) {
        AnnotatedInstance instance;
        instance.id = *id;
        instance.model = *model;
        instance.category = TextFromJson(object, "category").value_or("");
        instance.fine = TextFromJson(object, "quality").value_or("fine") == "fine";
        instance.scan_from_object = scan_from_object;
        if (object.contains("scale") && object["scale"].is_number())
          instance.scale = object["scale"];
        imported.instances.push_back(std::move(instance));
      } else {
        const Eigen::Isometry3d& first = imported.instances[place->second].scan_from_object;
        worst_m = std::max(worst_m, (first.translation() - scan_from_object.translation()).norm());
      }
    }
  }
  if (worst_m > 1e-3) {
    imported.warnings.push_back("'" + file.string() + "': the frames disagree by up to " +
                                std::to_string(1e3 * worst_m) + " mm; the first counts");
  }
  if (auto warning = MetreWarning(translations, file.string())) {
    imported.warnings.push_back(std::move(*warning));
  }
  return imported;
}

}  // namespace plumbline
