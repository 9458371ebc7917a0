// SPDX-License-Identifier: Apache-2.0
#include "engine/models/model_database.h"

#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "engine/base/data_paths.h"
#include "engine/base/files.h"
#include "engine/base/json_text.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_entry.h"

namespace plumbline {
namespace {

/// A texture that comes with a mesh, whose vertices have no colours, needs no more for its marks.
constexpr int kFacesForTexture = 5000;

std::string MeshHash(const TriangleMesh& mesh) {
  std::string bytes;
  bytes.append(reinterpret_cast<const char*>(mesh.vertices.data()),
               mesh.vertices.size() * sizeof(Eigen::Vector3f));
  bytes.append(reinterpret_cast<const char*>(mesh.triangles.data()),
               mesh.triangles.size() * sizeof(Eigen::Vector3i));
  // Their marks are lines of the model, too.
  bytes.append(reinterpret_cast<const char*>(mesh.colors.data()), 3 * mesh.colors.size());
  return HashHex(bytes);
}

Result<Symmetry> ParseSymmetry(const nlohmann::json& json, const std::string& where) {
  Symmetry symmetry;
  try {
    symmetry.order = IntFromJson(json.value("order", nlohmann::json(1)));
  } catch (const std::range_error&) {
    symmetry.order = -1;
  }
  if (symmetry.order < 0) {
    return Error{ErrorCode::kInvalidInput,
                 where + ": symmetry.order must be 0 (continuous), 1 (none) or more"};
  }
  const std::vector<double> axis = json.value("axis", std::vector<double>{0, 0, 1});
  if (axis.size() != 3 || !(Eigen::Vector3d(axis.data()).norm() > 1e-9)) {
    return Error{ErrorCode::kInvalidInput,
                 where + ": symmetry.axis must be three numbers, not all zero"};
  }
  symmetry.axis = Eigen::Vector3d(axis.data()).normalized();
  return symmetry;
}

}  // namespace

Result<CadModel> ReadModelEntry(const nlohmann::json& json, const std::filesystem::path& folder,
                                const std::string& where) {
  CadModel model;
  model.name = json.value("name", "");
  model.file = json.value("file", "");
  model.category = json.value("category", "");
  model.note = json.value("note", "");
  if (model.name.empty() || model.file.empty() || model.category.empty()) {
    return Error{ErrorCode::kInvalidInput, where + ": a model needs name, file and category"};
  }
  const std::string named = where + " ('" + model.name + "')";
  const std::string support = json.value("support", "any");
  if (support != "floor" && support != "any") {
    return Error{ErrorCode::kInvalidInput,
                 named + ": support is 'floor' or 'any', not '" + support + "'"};
  }
  model.support = support == "floor" ? Support::kFloor : Support::kAny;
  if (json.contains("back") && !json.at("back").is_boolean()) {
    return Error{ErrorCode::kInvalidInput,
                 named + ": back is true or false, not " + json.at("back").dump()};
  }
  model.back = json.value("back", false);
  if (json.contains("symmetry")) {
    Result<Symmetry> symmetry = ParseSymmetry(json.at("symmetry"), named);
    if (!symmetry.ok()) return symmetry.error();
    model.symmetry = *symmetry;
  }
  const Result<std::filesystem::path> file = PlaceInside(folder, model.file);
  if (!file.ok()) return Error{file.error().code, named + ": " + file.error().message};
  Result<TriangleMesh> mesh = ReadMesh(*file, kFacesForTexture);
  if (!mesh.ok()) return mesh.error();
  if (mesh->triangles.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + file->string() + "' has no faces; a model needs a surface"};
  }
  model.mesh = std::move(*mesh);
  return model;
}

Result<std::shared_ptr<const ModelDatabase>> ModelDatabase::Load(
    const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "models.json";
  Result<nlohmann::json> json = ReadJson(file);
  if (!json.ok()) return json.error();
  try {
    const std::string units = json->value("units", "m");
    if (units != "m") {
      return Error{ErrorCode::kUnsupported,
                   "'" + file.string() + "': units are '" + units +
                       "', not 'm'; make the database with `plumbline models build --unit " +
                       units + "`"};
    }
    std::vector<CadModel> models;
    std::set<std::string> names;
    for (const nlohmann::json& entry : json->at("models")) {
      const std::string where = "'" + file.string() + "', model " + std::to_string(models.size());
      Result<CadModel> model = ReadModelEntry(entry, folder, where);
      if (!model.ok()) return model.error();
      if (!names.insert(model->name).second) {
        return Error{ErrorCode::kInvalidInput,
                     where + ": the name '" + model->name + "' is taken; names must differ"};
      }
      models.push_back(std::move(*model));
    }
    if (models.empty())
      return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' lists no models"};
    auto database = std::make_shared<ModelDatabase>(*FromModels(std::move(models)));
    database->folder_ = folder;
    return std::shared_ptr<const ModelDatabase>(std::move(database));
  } catch (const nlohmann::json::exception& error) {
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' is no list of models: " + error.what()};
  }
}

CadModel Scaled(CadModel model, double factor) {
  model.mesh = Scaled(std::move(model.mesh), factor);
  model.bounds = BoundingBox(model.mesh);
  return model;
}

std::shared_ptr<const ModelDatabase> ModelDatabase::FromModels(std::vector<CadModel> models) {
  auto database = std::make_shared<ModelDatabase>();
  database->models_ = std::move(models);
  std::string all;
  for (std::size_t i = 0; i < database->models_.size(); ++i) {
    CadModel& model = database->models_[i];
    model.id = ModelId{static_cast<std::int32_t>(i)};
    model.bounds = BoundingBox(model.mesh);
    model.content_hash = MeshHash(model.mesh);
    all +=
        nlohmann::json{model.name,
                       model.category,
                       model.content_hash,
                       model.symmetry.order,
                       {model.symmetry.axis.x(), model.symmetry.axis.y(), model.symmetry.axis.z()},
                       model.support == Support::kFloor}
            .dump();
    if (model.back) all += "back";  // Only then: hashes of databases without stay as they were.
  }
  database->content_hash_ = HashHex(all);
  return database;
}

std::optional<ModelId> ModelDatabase::Find(std::string_view name) const {
  for (const CadModel& model : models_) {
    if (model.name == name) return model.id;
  }
  return std::nullopt;
}

std::vector<ModelId> ModelDatabase::OfCategory(std::string_view category) const {
  std::vector<ModelId> ids;
  for (const CadModel& model : models_) {
    if (model.category == category) ids.push_back(model.id);
  }
  return ids;
}

}  // namespace plumbline
