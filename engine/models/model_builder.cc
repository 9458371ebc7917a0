// SPDX-License-Identifier: Apache-2.0
#include "engine/models/model_builder.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/models/frame_settling.h"
#include "engine/models/mesh_file.h"
#include "engine/models/thing_table.h"

namespace plumbline {
namespace {

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// A name that is safe in file names: letters, digits, '-', '_' and '.'.
std::string ModelName(const std::filesystem::path& file) {
  std::string name = file.stem().string();
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') c = '_';
  }
  return name;
}

/// Metres, +z up, +x front, origin at the centre of the footprint on the supporting plane.
void BringIntoCanonicalFrame(ModelBuildReport& report, TriangleMesh& mesh) {
  Eigen::Matrix3d object_from_file;
  const Eigen::Vector3d up = report.up.value.vector(), front = report.front.value.vector();
  object_from_file << front.transpose(), up.cross(front).transpose(), up.transpose();
  Eigen::AlignedBox3d bounds;
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    points.push_back(report.unit.value * (object_from_file * vertex.cast<double>()));
    bounds.extend(points.back());
  }
  const Eigen::Vector3d origin(bounds.center().x(), bounds.center().y(), bounds.min().z());
  for (std::size_t i = 0; i < points.size(); ++i)
    mesh.vertices[i] = (points[i] - origin).cast<float>();
  report.object_from_file.linear() = object_from_file;
  report.object_from_file.translation() = -origin;
}

/// Paints the mesh, and keeps its texture under the model's name.
void TakeTexture(const TexturedMesh& read, const std::filesystem::path& mesh_file, int faces,
                 BuiltModel& built) {
  TriangleMesh& mesh = built.model.mesh;
  if (!read.texture.empty()) {
    const int before = static_cast<int>(mesh.triangles.size());
    PaintByTexture(read.texture, before + faces, mesh);
    built.report.faces_for_texture = static_cast<int>(mesh.triangles.size()) - before;
    built.texture_image = read.texture;
  }
  const std::filesystem::path file = mesh_file.parent_path() / mesh.texture_file;
  std::error_code ignored;
  if (!mesh.texture_file.empty() && std::filesystem::is_regular_file(file, ignored)) {
    built.texture = file;
    mesh.texture_file = built.model.name + "_texture" + file.extension().string();
  } else {
    mesh.texture_file = read.texture.empty() ? "" : built.model.name + "_texture.png";
  }
}

/// COCO's name for it; "unknown" with a warning where there is none.
std::string CategoryOf(const Thing* thing, const ModelBuildOptions& options,
                       std::vector<std::string>& warnings) {
  if (!options.category.empty()) return options.category;
  if (thing != nullptr && thing->in_coco) return std::string(thing->name);
  warnings.push_back((thing == nullptr
                          ? std::string("no category")
                          : "no category: COCO has none for a " + std::string(thing->name)) +
                     ": a detector will never propose it; state its COCO name with --category");
  return "unknown";
}

/// What the entry says is guessed, as long as nobody states it.
nlohmann::json UnsureOf(const ModelBuildReport& report) {
  nlohmann::json unsure = nlohmann::json::object();
  const auto add = [&unsure](const char* what, bool sure, double confidence) {
    if (!sure) unsure[what] = 0.01 * std::round(100 * confidence);
  };
  add("unit", report.unit.sure(), report.unit.confidence);
  add("up", report.up.sure(), report.up.confidence);
  add("front", report.front.sure(), report.front.confidence);
  return unsure;
}

nlohmann::json EntryOf(const BuiltModel& built) {
  const CadModel& model = built.model;
  const Eigen::Vector3d origin = built.report.object_from_file.inverse().translation();
  nlohmann::json entry = {
      {"name", model.name},
      {"file", model.file},
      {"category", model.category},
      {"symmetry",
       {{"axis", {model.symmetry.axis.x(), model.symmetry.axis.y(), model.symmetry.axis.z()}},
        {"order", model.symmetry.order}}},
      {"support", model.support == Support::kFloor ? "floor" : "any"},
      {"note", model.note},
      {"faces", model.mesh.triangles.size()},
      {"source",
       {{"file", built.source.filename().string()},
        {"unit", UnitText(built.report.unit.value)},
        {"up", built.report.up.value.text()},
        {"front", built.report.front.value.text()},
        {"origin_m", {origin.x(), origin.y(), origin.z()}},
        {"faces", built.report.decimation.faces_before}}}};
  if (nlohmann::json unsure = UnsureOf(built.report); !unsure.empty())
    entry["source"]["unsure"] = std::move(unsure);
  if (model.back) entry["back"] = true;  // Else what the entry says already stays.
  return entry;
}

Status StoreTexture(const BuiltModel& built, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / built.model.mesh.texture_file;
  if (!built.texture.empty()) {
    const Result<std::string> texture = ReadFile(built.texture);
    if (!texture.ok()) return texture.error();
    return WriteFileAtomically(file, *texture);
  }
  if (built.texture_image.empty()) return {};
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", built.texture_image, bytes);
  return WriteFileAtomically(file, std::string(bytes.begin(), bytes.end()));
}

}  // namespace

Result<BuiltModel> BuildModel(const std::filesystem::path& mesh_file,
                              const ModelBuildOptions& options) {
  Result<TexturedMesh> mesh = ReadTexturedMesh(mesh_file);
  if (!mesh.ok()) return mesh.error();
  return BuildModelFrom(*mesh, ModelName(mesh_file), mesh_file, options);
}

Result<BuiltModel> BuildModelFrom(const TexturedMesh& read, const std::string& name,
                                  const std::filesystem::path& mesh_file,
                                  const ModelBuildOptions& options) {
  const auto failed = [&mesh_file](const Error& error) {
    return Error{error.code, "'" + mesh_file.string() + "': " + error.message};
  };
  BuiltModel built;
  built.source = mesh_file;
  CadModel& model = built.model;
  ModelBuildReport& report = built.report;
  report.warnings = read.warnings;
  model.mesh = CleanMesh(read.mesh, report.cleanup);
  if (model.mesh.triangles.empty()) {
    return failed(
        {ErrorCode::kDegenerate, "it has no faces of positive area; a model needs a surface"});
  }
  model.name = name;
  model.file = model.name + ".ply";
  const Thing* thing = options.category.empty() ? ThingInName(name) : FindThing(options.category);
  TriangleMesh painted = model.mesh;  // Fronts show themselves by what is drawn on them, too.
  if (!read.texture.empty()) {
    PaintByTexture(read.texture, static_cast<int>(painted.triangles.size()) + options.faces,
                   painted);
  }
  if (const Status status = SettleFrame(painted, read.frame, Lower(mesh_file.extension().string()),
                                        options, thing, report);
      !status.ok()) {
    return failed(status.error());
  }
  model.category = CategoryOf(thing, options, report.warnings);
  model.support =
      thing != nullptr && thing->in_coco && thing->on_floor ? Support::kFloor : Support::kAny;
  model.symmetry.order = options.symmetry;
  model.back = options.back;
  BringIntoCanonicalFrame(report, model.mesh);
  Result<TriangleMesh> decimated = DecimateMesh(model.mesh, options.faces, report.decimation);
  if (!decimated.ok()) return failed(decimated.error());
  model.mesh = std::move(*decimated);
  TakeTexture(read, mesh_file, options.faces, built);
  ComputeNormals(model.mesh);
  model.bounds = BoundingBox(model.mesh);
  return built;
}

Status StoreModel(const BuiltModel& built, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + folder.string() + "': " + error.message()};
  const std::filesystem::path list = folder / "models.json";
  nlohmann::json json = {{"units", "m"}, {"models", nlohmann::json::array()}};
  if (std::filesystem::exists(list, error)) {
    Result<nlohmann::json> existing = ReadJson(list);
    if (!existing.ok()) return existing.error();
    json = std::move(*existing);
    if (!json.is_object() || !json.contains("models") || !json["models"].is_array()) {
      return Error{
          ErrorCode::kCorrupt,
          "'" + list.string() + "' is no list of models; move it away or choose another folder"};
    }
  }
  if (const Status copied = StoreTexture(built, folder); !copied.ok()) return copied;
  if (const Status written = WritePly(folder / built.model.file, built.model.mesh); !written.ok())
    return written;
  nlohmann::json& models = json["models"];
  const auto same = std::find_if(models.begin(), models.end(), [&](const nlohmann::json& entry) {
    return entry.is_object() && entry.value("name", nlohmann::json()) == built.model.name;
  });
  if (same == models.end()) {
    models.push_back(EntryOf(built));
  } else {
    same->update(EntryOf(built));
  }
  return WriteJson(list, json);
}

}  // namespace plumbline
