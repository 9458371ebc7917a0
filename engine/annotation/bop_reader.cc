// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <map>

#include <nlohmann/json.hpp>

#include "engine/annotation/bop_files.h"
#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

constexpr double kMillimetresPerMetre = 1000;

/// The folder of the first scene: the dataset's own, or SPLIT/NNNNNN below it.
std::optional<std::filesystem::path> FirstScene(const std::filesystem::path& folder) {
  std::error_code ignored;
  std::vector<path> scenes;
  if (std::filesystem::exists(folder / "scene_gt.json", ignored)) return folder;
  for (const auto& split : std::filesystem::directory_iterator(folder, ignored)) {
    if (!split.is_directory(ignored)) continue;
    for (const auto& scene : std::filesystem::directory_iterator(split.path(), ignored)) {
      if (std::filesystem::exists(scene.path() / "scene_gt.json", ignored)) {
        scenes.push_back(scene.path());
      }
    }
  }
  if (scenes.empty()) return std::nullopt;
  return *std::min_element(scenes.begin(), scenes.end());
}

/// Rotation and translation [m] under two keys.
std::optional<Eigen::Isometry3d> PoseOf(const nlohmann::json& entry, const char* rotation,
                                        const char* translation) {
  if (!entry.is_object() || !entry.contains(rotation) || !entry.contains(translation))
    return std::nullopt;
  const auto r = VectorFromJson(entry[rotation], 9), t = VectorFromJson(entry[translation], 3);
  if (!r || !t) return std::nullopt;
  nlohmann::json rows = nlohmann::json::array();
  for (int i = 0; i < 3; ++i) {
    rows.push_back({(*r)[3 * i], (*r)[3 * i + 1], (*r)[3 * i + 2], (*t)[i] / kMillimetresPerMetre});
  }
  rows.push_back({0, 0, 0, 1});
  return IsometryFromJson(rows);
}

struct ModelName {
  std::string name, category;
  Eigen::Vector3d center{0, 0, 0};
};

ModelName NameOf(const nlohmann::json& names, int obj_id) {
  char fallback[16];
  std::snprintf(fallback, sizeof(fallback), "obj_%06d", obj_id);
  ModelName result{fallback, "", {0, 0, 0}};
  const auto found = names.find(std::to_string(obj_id));
  if (found == names.end() || !found->is_object()) return result;
  result.name = TextFromJson(*found, "name").value_or(fallback);
  result.category = TextFromJson(*found, "category").value_or("");
  if (found->contains("center_m")) {
    if (const auto center = VectorFromJson((*found)["center_m"], 3)) result.center = *center;
  }
  return result;
}

}  // namespace

Result<ImportedPoses> ReadBop(const std::filesystem::path& folder) {
  const std::optional<std::filesystem::path> scene = FirstScene(folder);
  if (!scene) {
    return Error{
        ErrorCode::kNotFound,
        "'" + folder.string() + "' is no BOP dataset: it has no SPLIT/000000/scene_gt.json"};
  }
  const Result<nlohmann::json> truth = ReadJson(*scene / "scene_gt.json");
  if (!truth) return truth.error();
  const Result<nlohmann::json> cameras = ReadJson(*scene / "scene_camera.json");
  if (!cameras) return cameras.error();
  nlohmann::json names = nlohmann::json::object();
  for (const std::filesystem::path& root : {folder, scene->parent_path().parent_path()}) {
    if (const auto read = ReadJson(root / "models" / "plumbline_models.json"); read.ok()) {
      names = *read;
      break;
    }
  }
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "'" + scene->string() + "': " + what};
  };
  if (!truth->is_object() || !cameras->is_object()) {
    return bad("scene_gt.json and scene_camera.json must map the numbers of images");
  }
  // By number: keys sort as texts.
  std::map<int, std::string> images;
  for (const auto& [key, entries] : truth->items()) images[std::atoi(key.c_str())] = key;
  ImportedPoses imported;
  std::map<int, int> counts;
  std::size_t near = 0, poses = 0;
  for (const auto& [number, key] : images) {
    const auto camera = cameras->find(key);
    const auto cam_from_scan =
        camera == cameras->end() ? std::nullopt : PoseOf(*camera, "cam_R_w2c", "cam_t_w2c");
    if (!cam_from_scan) {
      return bad("image " + key +
                 " has no cam_R_w2c and cam_t_w2c: without them its poses have no "
                 "common frame");
    }
    for (const nlohmann::json& entry : (*truth)[key]) {
      const auto cam_from_model = PoseOf(entry, "cam_R_m2c", "cam_t_m2c");
      const bool numbered =
          entry.is_object() && entry.contains("obj_id") && entry["obj_id"].is_number_integer();
      const int obj_id = numbered ? entry["obj_id"].get<int>() : -1;
      if (!cam_from_model || obj_id < 0) {
        return bad("an entry of image " + key + " has no obj_id or no rigid pose within 1000 km");
      }
      near += cam_from_model->translation().norm() < 0.02;
      ++poses;
      const ModelName model = NameOf(names, obj_id);
      AnnotatedInstance instance;
      instance.model = model.name;
      instance.category = model.category;
      instance.scan_from_object =
          cam_from_scan->inverse() * *cam_from_model * Eigen::Translation3d(-model.center);
      const bool known = std::any_of(
          imported.instances.begin(), imported.instances.end(),
          [&](const AnnotatedInstance& other) {
            return other.model == instance.model &&
                   (other.scan_from_object.translation() - instance.scan_from_object.translation())
                           .norm() < 0.05;
          });
      if (known) continue;
      instance.id = model.name + "_" + std::to_string(counts[obj_id]++);
      imported.instances.push_back(std::move(instance));
    }
  }
  if (2 * near > poses) {
    imported.warnings.push_back("'" + scene->string() +
                                "' should hold millimetres, but most objects are less than 20 mm "
                                "away: are these metres?");
  }
  return imported;
}

}  // namespace plumbline
