// SPDX-License-Identifier: Apache-2.0
#include "engine/models/model_check.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "engine/base/files.h"
#include "engine/models/model_entry.h"

namespace plumbline {
namespace {

std::string Millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.0f mm", 1000 * metres);
  return text;
}

void CheckShape(const TriangleMesh& mesh, Support support, ModelCheck& check) {
  check.faces = static_cast<int>(mesh.triangles.size());
  check.vertices = static_cast<int>(mesh.vertices.size());
  check.edges = CountEdges(mesh);
  CleanMesh(mesh, check.flaws);
  const Eigen::AlignedBox3d bounds(BoundingBox(mesh).min().cast<double>(),
                                   BoundingBox(mesh).max().cast<double>());
  check.size_m = bounds.sizes();
  check.footprint_m = bounds.center().head<2>();
  check.lowest_m = bounds.min().z();
  const double largest = check.size_m.maxCoeff();
  if (check.flaws.degenerate_faces + check.flaws.duplicate_faces == check.faces) {
    check.problems.push_back("no face has an area");
  }
  if (largest > 30 || largest < 0.005) {
    char text[96];
    std::snprintf(text, sizeof(text),
                  "its longest side is %.3g m; build it again with the right --unit", largest);
    check.problems.push_back(text);
  } else if (largest > 6 || largest < 0.03) {
    check.warnings.push_back("an unusual size; is the unit right?");
  }
  if (check.footprint_m.norm() > 0.1 * largest) {
    check.warnings.push_back("its origin is " + Millimetres(check.footprint_m.norm()) +
                             " off the centre of its footprint");
  }
  if (std::abs(check.lowest_m) > 0.03 * check.size_m.z() + 0.005) {
    check.warnings.push_back(
        "its lowest point is at " + Millimetres(check.lowest_m) + ", not on the supporting plane" +
        (support == Support::kFloor ? ": with the floor prior it will be placed wrongly" : ""));
  }
  if (check.faces > 50000)
    check.warnings.push_back("many faces; scoring slows down (decimate with --faces)");
  if (check.flaws.degenerate_faces + check.flaws.duplicate_faces > 0) {
    check.warnings.push_back(std::to_string(check.flaws.degenerate_faces) + " degenerate and " +
                             std::to_string(check.flaws.duplicate_faces) + " duplicate faces");
  }
}

/// Of unit, up and front, what `models build` was not sure of, and how sure it was.
std::map<std::string, double> UnsureOf(const nlohmann::json& entry) {
  const nlohmann::json source = entry.value("source", nlohmann::json::object());
  return source.is_object() ? source.value("unsure", std::map<std::string, double>())
                            : std::map<std::string, double>();
}

ModelCheck CheckEntry(const nlohmann::json& entry, const std::filesystem::path& folder,
                      const std::string& where) {
  ModelCheck check;
  try {
    check.name = entry.value("name", "");
    check.file = entry.value("file", "");
    check.category = entry.value("category", "");
    const Result<CadModel> model = ReadModelEntry(entry, folder, where);
    if (!model.ok()) {
      check.problems.push_back(model.error().message);
      return check;
    }
    const TriangleMesh& mesh = model->mesh;
    check.has_colors = !mesh.colors.empty();
    check.has_texture = !mesh.texture_coordinates.empty() && !mesh.texture_file.empty();
    std::error_code ignored;
    if (check.has_texture && !std::filesystem::exists(folder / mesh.texture_file, ignored)) {
      check.warnings.push_back("its texture '" + mesh.texture_file + "' is missing");
    }
    for (const auto& [what, share] : UnsureOf(entry)) {
      check.warnings.push_back("its " + what + " is a guess of " +
                               std::to_string(std::lround(100 * share)) +
                               " %; build it again and state it with --" + what);
    }
    if (check.category == "unknown")
      check.warnings.push_back("no category; a detector will never propose it");
    CheckShape(mesh, model->support, check);
  } catch (const nlohmann::json::exception& error) {
    check.problems.push_back(where + " is no model: " + error.what());
  }
  return check;
}

}  // namespace

Result<std::vector<ModelCheck>> CheckModels(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "models.json";
  const Result<nlohmann::json> json = ReadJson(file);
  if (!json.ok()) return json.error();
  if (!json->is_object() || !json->contains("models") || !json->at("models").is_array() ||
      json->at("models").empty()) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' lists no models"};
  }
  if (json->value("units", nlohmann::json("m")) != "m") {
    return Error{ErrorCode::kUnsupported, "'" + file.string() + "': units must be 'm'"};
  }
  std::vector<ModelCheck> checks;
  std::set<std::string> names;
  for (const nlohmann::json& entry : json->at("models")) {
    checks.push_back(CheckEntry(entry, folder,
                                "'" + file.string() + "', model " + std::to_string(checks.size())));
    if (!names.insert(checks.back().name).second)
      checks.back().problems.push_back("its name is taken by another model");
  }
  return checks;
}

}  // namespace plumbline
