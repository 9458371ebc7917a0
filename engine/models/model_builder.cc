// SPDX-License-Identifier: Apache-2.0
#include "engine/models/model_builder.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/base/files.h"
#include "engine/models/category_table.h"
#include "engine/models/mesh_file.h"

namespace plumbline {
namespace {

constexpr double kSure = 0.8;

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

std::string CategoryInName(const std::filesystem::path& file) {
  std::string name = Lower(file.stem().string());
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '_' || c == '-'; }, ' ');
  for (const CategoryHabit& category : kCategoryHabits) {
    if (name.find(category.name) != std::string::npos) return std::string(category.name);
  }
  return "";
}

Support SupportOf(const std::string& category) {
  const CategoryHabit* usual = FindCategoryHabit(category);
  return usual != nullptr && usual->on_floor ? Support::kFloor : Support::kAny;
}

template <typename T>
std::string GuessWarning(const std::string& what, const std::string& value, const Guess<T>& guess,
                         const char* option) {
  const char* surety = guess.confidence >= 0.95    ? "quite sure"
                       : guess.confidence >= kSure ? "fairly sure"
                                                   : "little more than a guess";
  return what + " taken as " + value + ", " + guess.reason + " (" + surety + ": " +
         std::to_string(std::lround(100 * guess.confidence)) + " %; state it with " + option + ")";
}

/// Unit, up and front from the options or guessed into the report.
Status Settle(const TriangleMesh& mesh, const std::string& extension, const std::string& category,
              const ModelBuildOptions& options, ModelBuildReport& report) {
  if (options.unit) {
    report.unit = *options.unit;
  } else {
    const Guess<LengthUnit> unit = GuessUnit(BoundingBox(mesh).sizes(), category, extension);
    report.unit = unit.value;
    if (unit.confidence < 1)
      report.warnings.push_back(GuessWarning("unit", NameOf(unit.value), unit, "--unit"));
  }
  if (options.up && options.up_sign_stated) {
    report.up = *options.up;
  } else {
    const auto up = GuessUp(mesh, extension, category,
                            options.up ? std::optional(options.up->axis) : std::nullopt);
    if (!up.ok()) return up.error();
    report.up = up->value;
    if (!options.up) {
      if (up->confidence < 1)
        report.warnings.push_back(GuessWarning("up", up->value.text(), *up, "--up"));
    } else if (up->value.sign != options.up->sign && up->confidence > kSure) {
      report.warnings.push_back(
          GuessWarning("up", up->value.text(), *up, ("--up=" + options.up->text()).c_str()) +
          ": with " + options.up->text() + " up it would stand on its head");
    } else {
      report.up = *options.up;
    }
  }
  if (options.front && options.front->axis == report.up.axis) {
    return Error{ErrorCode::kInvalidInput,
                 "front " + options.front->text() + " and up " + report.up.text() +
                     " lie on one axis; state two different ones with --front and --up"};
  }
  if (options.front) {
    report.front = *options.front;
    return {};
  }
  const auto front = GuessFront(mesh, report.up);
  if (!front.ok()) return front.error();
  report.front = front->value;
  // What looks the same all round has no front to be wrong about.
  if (options.symmetry != 0)
    report.warnings.push_back(GuessWarning("front", front->value.text(), *front, "--front"));
  return {};
}

/// Metres, +z up, +x front, origin at the centre of the footprint on the supporting plane.
void BringIntoCanonicalFrame(ModelBuildReport& report, TriangleMesh& mesh) {
  Eigen::Matrix3d object_from_file;
  object_from_file.row(0) = report.front.vector();
  object_from_file.row(1) = report.up.vector().cross(report.front.vector());
  object_from_file.row(2) = report.up.vector();
  Eigen::AlignedBox3d bounds;
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    points.push_back(MetresPer(report.unit) * (object_from_file * vertex.cast<double>()));
    bounds.extend(points.back());
  }
  const Eigen::Vector3d origin(bounds.center().x(), bounds.center().y(), bounds.min().z());
  for (std::size_t i = 0; i < points.size(); ++i)
    mesh.vertices[i] = (points[i] - origin).cast<float>();
  report.object_from_file.linear() = object_from_file;
  report.object_from_file.translation() = -origin;
}

void FindTexture(const std::filesystem::path& mesh_file, BuiltModel& built) {
  TriangleMesh& mesh = built.model.mesh;
  if (mesh.texture_file.empty()) return;
  const std::filesystem::path texture = mesh_file.parent_path() / mesh.texture_file;
  std::error_code ignored;
  if (std::filesystem::is_regular_file(texture, ignored)) {
    built.texture = texture;
    mesh.texture_file = built.model.name + "_texture" + texture.extension().string();
  } else {
    built.report.warnings.push_back("its texture '" + texture.string() +
                                    "' is missing and left out");
    mesh.texture_file.clear();
  }
}

nlohmann::json EntryOf(const BuiltModel& built) {
  const CadModel& model = built.model;
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
        {"unit", NameOf(built.report.unit)},
        {"up", built.report.up.text()},
        {"front", built.report.front.text()},
        {"faces", built.report.decimation.faces_before}}}};
  if (model.back) entry["back"] = true;  // Else what the entry says already stays.
  return entry;
}

}  // namespace

Result<BuiltModel> BuildModel(const std::filesystem::path& mesh_file,
                              const ModelBuildOptions& options) {
  Result<TriangleMesh> mesh = ReadMesh(mesh_file);
  if (!mesh.ok()) return mesh.error();
  return BuildModelFrom(*mesh, ModelName(mesh_file), mesh_file, options);
}

Result<BuiltModel> BuildModelFrom(const TriangleMesh& mesh, const std::string& name,
                                  const std::filesystem::path& mesh_file,
                                  const ModelBuildOptions& options) {
  const auto failed = [&mesh_file](const Error& error) {
    return Error{error.code, "'" + mesh_file.string() + "': " + error.message};
  };
  BuiltModel built;
  built.source = mesh_file;
  CadModel& model = built.model;
  ModelBuildReport& report = built.report;
  model.mesh = CleanMesh(mesh, report.cleanup);
  if (model.mesh.triangles.empty()) {
    return failed(
        {ErrorCode::kDegenerate, "it has no faces of positive area; a model needs a surface"});
  }
  model.name = name;
  model.file = model.name + ".ply";
  model.category = options.category.empty() ? CategoryInName(name) : options.category;
  const std::string extension = Lower(mesh_file.extension().string());
  if (const Status status = Settle(model.mesh, extension, model.category, options, report);
      !status.ok()) {
    return failed(status.error());
  }
  if (model.category.empty()) {
    model.category = "unknown";
    report.warnings.push_back(
        "no category: a detector will never propose it; state its COCO name with --category");
  }
  model.support = SupportOf(model.category);
  model.symmetry.order = options.symmetry;
  model.back = options.back;
  BringIntoCanonicalFrame(report, model.mesh);
  Result<TriangleMesh> decimated = DecimateMesh(model.mesh, options.faces, report.decimation);
  if (!decimated.ok()) return failed(decimated.error());
  model.mesh = std::move(*decimated);
  ComputeNormals(model.mesh);
  model.bounds = BoundingBox(model.mesh);
  FindTexture(mesh_file, built);
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
  if (!built.texture.empty()) {
    const Result<std::string> texture = ReadFile(built.texture);
    if (!texture.ok()) return texture.error();
    const Status copied = WriteFileAtomically(folder / built.model.mesh.texture_file, *texture);
    if (!copied.ok()) return copied;
  }
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
