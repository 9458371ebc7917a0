// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <set>

#include <nlohmann/json.hpp>

#include "engine/annotation/crop_cut.h"
#include "engine/annotation/pose_exchange.h"
#include "engine/base/data_paths.h"
#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"
#include "engine/geometry/closest_triangle.h"
#include "engine/models/mesh_file.h"

namespace plumbline {
namespace {

/// Ours (z up) from VISMA's (y up): (x, y, z) -> (x, -z, y).
Eigen::Isometry3d ObjectFromYUp() {
  Eigen::Isometry3d object_from_y_up = Eigen::Isometry3d::Identity();
  object_from_y_up.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return object_from_y_up;
}

nlohmann::json TwelveNumbers(const Eigen::Isometry3d& pose) {
  nlohmann::json numbers = nlohmann::json::array();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) numbers.push_back(pose.matrix()(r, c));
  }
  return numbers;
}

std::optional<Eigen::Isometry3d> FromTwelveNumbers(const nlohmann::json& json) {
  if (!VectorFromJson(json, 12)) return std::nullopt;
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 3; ++r) {
    rows.push_back({json[4 * r], json[4 * r + 1], json[4 * r + 2], json[4 * r + 3]});
  }
  rows.push_back({0, 0, 0, 1});
  return IsometryFromJson(rows);
}

/// What stands before the last underscore.
std::string ModelOf(const std::string& name) { return name.substr(0, name.rfind('_')); }

/// `<model>_<N>`: the id itself where it has that form, else a number of its own.
std::vector<std::string> VismaNames(const AnnotationDocument& document) {
  std::set<std::string> taken;
  for (const AnnotatedInstance& instance : document.instances) taken.insert(instance.id);
  std::vector<std::string> names;
  for (const AnnotatedInstance& instance : document.instances) {
    std::string name = instance.id;
    for (int number = 0; ModelOf(name) != instance.model || name == instance.model; ++number) {
      const std::string candidate = instance.model + "_" + std::to_string(number);
      if (taken.insert(candidate).second) name = candidate;
    }
    names.push_back(name);
  }
  return names;
}

/// An OBJ as VISMA's CAD folder holds it: +y up, six columns a vertex.
std::string ObjText(const TriangleMesh& mesh) {
  std::string text = "# metres, +y up\n";
  char line[160];
  const Eigen::Isometry3f y_up_from_object = ObjectFromYUp().inverse().cast<float>();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f v = y_up_from_object * mesh.vertices[i];
    float color[3] = {0.7f, 0.7f, 0.7f};
    if (!mesh.colors.empty()) {
      for (int c = 0; c < 3; ++c) color[c] = static_cast<float>(mesh.colors[i][c]) / 255;
    }
    std::snprintf(line, sizeof(line), "v %.9g %.9g %.9g %.4g %.4g %.4g\n", v.x(), v.y(), v.z(),
                  color[0], color[1], color[2]);
    text += line;
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    std::snprintf(line, sizeof(line), "f %d %d %d\n", t.x() + 1, t.y() + 1, t.z() + 1);
    text += line;
  }
  return text;
}

constexpr const char* kReadme =
    "alignment.json: name -> 12 numbers, row-major 3x4, model to scan, metres. The models are "
    "those\n"
    "of CAD/, +y up; Plumbline's z-up models are theirs turned by (x, y, z) -> (x, -z, y).\n"
    "result_alignment.json: T_ef_corvis, 12 numbers, row-major 3x4, sequence's world to scan, "
    "metres.\n";

}  // namespace

Status WriteVisma(const AnnotationDocument& document, const ModelDatabase* models,
                  const std::filesystem::path& folder) {
  for (const AnnotatedInstance& instance : document.instances) {
    for (const std::string& name : {instance.id, instance.model}) {
      if (!IsFileName(name))
        return InvalidInput("'" + name +
                            "' cannot be the name of a file, as VISMA's are; rename '" +
                            instance.id + "'");
    }
  }
  std::error_code error;
  std::filesystem::create_directories(models ? folder / "CAD" : folder, error);
  if (error) {
    return Error{ErrorCode::kIo, "cannot make '" + folder.string() + "': " + error.message()};
  }
  nlohmann::json names = VismaNames(document), alignment = nlohmann::json::object();
  std::set<std::string> used;
  for (std::size_t i = 0; i < document.instances.size(); ++i) {
    const AnnotatedInstance& instance = document.instances[i];
    alignment[names[i].get<std::string>()] =
        TwelveNumbers(instance.scan_from_object * ObjectFromYUp());
    used.insert(instance.model);
  }
  for (const Crop& crop : document.crops) {
    if (crop.into == Crop::Into::kFragment && !alignment.contains(crop.id)) {
      names.push_back(crop.id);  // Still to be aligned.
    }
  }
  Status status = WriteJson(folder / "objects.json", {{"entries", names}});
  if (status.ok()) status = WriteJson(folder / "alignment.json", alignment);
  if (status.ok()) status = WriteFileAtomically(folder / "README.txt", kReadme);
  if (status.ok() && document.scan_from_world) {
    status = WriteJson(folder / "result_alignment.json",
                       {{"T_ef_corvis", TwelveNumbers(*document.scan_from_world)}});
  }
  for (const std::string& name : used) {
    const auto id = models ? models->Find(name) : std::nullopt;
    if (!status.ok() || !id) continue;
    status =
        WriteFileAtomically(folder / "CAD" / (name + ".obj"), ObjText(models->model(*id).mesh));
  }
  return status;
}

Status WriteVismaScene(const AnnotationDocument& document, const ModelDatabase& models,
                       const TriangleMesh& scan, double reach_m,
                       const std::filesystem::path& folder) {
  const std::vector<std::string> names = VismaNames(document);
  TriangleMesh augmented = scan;
  for (std::size_t i = 0; i < document.instances.size(); ++i) {
    const AnnotatedInstance& instance = document.instances[i];
    const auto id = models.Find(instance.model);
    if (!id) {
      return Error{ErrorCode::kInvalidInput, "the model '" + instance.model + "' of '" +
                                                 instance.id + "' is not in the database"};
    }
    const CadModel& model = models.model(*id);
    const auto surface = ClosestTriangleSearch::Build(model.mesh);
    if (!surface) return surface.error();
    const Eigen::Isometry3d object_from_scan = instance.scan_from_object.inverse();
    const auto reach = static_cast<float>(reach_m);
    const Eigen::AlignedBox3f near(model.bounds.min().array() - reach,
                                   model.bounds.max().array() + reach);
    TriangleMesh fragment;
    for (std::size_t k = 0; k < scan.vertices.size(); ++k) {
      const Eigen::Vector3d point = object_from_scan * scan.vertices[k].cast<double>();
      if (!near.contains(Eigen::Vector3f(point.cast<float>()))) continue;
      if (!(*surface)->FindWithin(point, reach_m)) continue;
      fragment.vertices.push_back(scan.vertices[k]);
      if (!scan.colors.empty()) fragment.colors.push_back(scan.colors[k]);
    }
    const Status written = WritePly(folder / (names[i] + ".ply"), fragment);
    if (!written.ok()) return written;
    Append(Transformed(model.mesh, instance.scan_from_object), augmented);
  }
  for (const Crop& crop : document.crops) {
    if (crop.into != Crop::Into::kFragment) continue;
    const Result<TriangleMesh> cut = CutOut(scan, crop);
    if (!cut) return cut.error();
    if (const Status written = WritePly(folder / (crop.id + ".ply"), *cut); !written.ok()) {
      return written;
    }
  }
  return WritePly(folder / "augmented_scene.ply", augmented);
}

Result<ImportedPoses> ReadVisma(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "alignment.json";
  const Result<nlohmann::json> alignment = ReadJson(file);
  if (!alignment) return alignment.error();
  if (!alignment->is_object()) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' must map names to 12 numbers"};
  }
  ImportedPoses imported;
  std::vector<Eigen::Vector3d> translations;
  for (const auto& [name, numbers] : alignment->items()) {
    const auto pose = FromTwelveNumbers(numbers);
    if (!pose) {
      return Error{ErrorCode::kInvalidInput,
                   "'" + file.string() + "': '" + name +
                       "' has no rigid pose of 12 numbers, row by row, within 1000 km"};
    }
    AnnotatedInstance instance;
    instance.id = name;
    instance.model = ModelOf(name);
    instance.scan_from_object = *pose * ObjectFromYUp().inverse();
    translations.push_back(pose->translation());
    imported.instances.push_back(std::move(instance));
  }
  if (auto warning = MetreWarning(translations, file.string())) {
    imported.warnings.push_back(std::move(*warning));
  }
  std::error_code ignored;
  if (std::filesystem::exists(folder / "objects.json", ignored)) {
    const Result<nlohmann::json> objects = ReadJson(folder / "objects.json");
    if (!objects) return objects.error();
    if (!objects->is_object()) {
      return Error{ErrorCode::kInvalidInput, "'" + (folder / "objects.json").string() +
                                                 "' must hold a list 'entries' of names"};
    }
    for (const nlohmann::json& name : objects->value("entries", nlohmann::json::array())) {
      if (!name.is_string() || alignment->contains(name.get<std::string>())) continue;
      imported.warnings.push_back("'" + file.string() + "' has no pose of '" +
                                  name.get<std::string>() + "', which objects.json lists");
    }
  }
  if (std::filesystem::exists(folder / "result_alignment.json", ignored)) {
    const Result<nlohmann::json> result = ReadJson(folder / "result_alignment.json");
    if (!result) return result.error();
    const auto pose = result->contains("T_ef_corvis") ? FromTwelveNumbers((*result)["T_ef_corvis"])
                                                      : std::nullopt;
    if (!pose) {
      return Error{ErrorCode::kInvalidInput,
                   "'" + (folder / "result_alignment.json").string() +
                       "' needs 'T_ef_corvis', a rigid pose of 12 numbers within 1000 km"};
    }
    imported.scan_from_world = *pose;
  }
  return imported;
}

}  // namespace plumbline
