// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>

#include "app/info/info_text.h"
#include "app/info/path_info.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_check.h"

namespace plumbline {

Likeness ProbeModels(const std::filesystem::path& path) {
  std::error_code ignored;
  // A sequence has its models in a folder of its own.
  return std::filesystem::exists(path / "models.json", ignored) ? Likeness::kCertain
                                                                : Likeness::kNone;
}

Result<PathInfo> DescribeModels(const std::filesystem::path& path) {
  const Result<std::vector<ModelCheck>> checks = CheckModels(path);
  if (!checks.ok()) return checks.error();
  PathInfo info;
  info.title = "database of models";
  std::map<std::string, std::size_t> categories;
  std::size_t faces = 0, warnings = 0;
  info.json["models"] = nlohmann::json::array();
  std::string names;
  for (const ModelCheck& check : checks.value()) {
    ++categories[check.category.empty() ? "no category" : check.category];
    faces += static_cast<std::size_t>(check.faces);
    warnings += check.warnings.size();
    names += (names.empty() ? "" : ", ") + check.name;
    info.json["models"].push_back(
        {{"name", check.name},
         {"category", check.category},
         {"faces", check.faces},
         {"size_m", {check.size_m.x(), check.size_m.y(), check.size_m.z()}}});
    for (const std::string& problem : check.problems)
      info.odd.push_back("'" + check.name + "' cannot be used: " + problem);
  }
  std::string list;
  for (const auto& [category, count] : categories)
    list += (list.empty() ? "" : ", ") + std::to_string(count) + " " + category;
  constexpr std::size_t kNames = 120;
  if (names.size() > kNames) names = names.substr(0, kNames) + " ..";
  info.lines = {{"Models", std::to_string(checks.value().size()) + ": " + names},
                {"Categories", list},
                {"Faces", std::to_string(faces) + " in all"}};
  if (warnings > 0) {
    info.odd.push_back(Counted(warnings, "remark", "remarks") +
                       " of models check, such as how a mesh stands; run it to read them.");
  }
  return info;
}

Likeness ProbeMesh(const std::filesystem::path& path) {
  return IsMeshName(path) ? Likeness::kPossible : Likeness::kNone;
}

Result<PathInfo> DescribeMesh(const std::filesystem::path& path) {
  const Result<TriangleMesh> read = ReadMesh(path);
  if (!read.ok()) return read.error();
  const TriangleMesh& mesh = read.value();
  PathInfo info;
  info.title = mesh.triangles.empty() ? "point cloud" : "mesh";
  info.lines.push_back({"Geometry", Format("%zu vertices, %zu triangles", mesh.vertices.size(),
                                           mesh.triangles.size())});
  const Eigen::AlignedBox3f box = BoundingBox(mesh);
  const Eigen::Vector3d size =
      mesh.empty() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(box.sizes().cast<double>());
  info.lines.push_back({"Size", SizeText(size) + ", if its unit is the metre"});
  std::string attributes;
  for (const auto& [name, present] :
       {std::pair("colours", !mesh.colors.empty()), std::pair("normals", !mesh.normals.empty()),
        std::pair("a texture", !mesh.texture_file.empty())}) {
    if (present) attributes += (attributes.empty() ? "" : ", ") + std::string(name);
  }
  if (!attributes.empty()) info.lines.push_back({"With", attributes});
  info.json["vertices"] = mesh.vertices.size();
  info.json["triangles"] = mesh.triangles.size();
  info.json["size_m"] = {size.x(), size.y(), size.z()};
  info.json["colors"] = !mesh.colors.empty();
  if (mesh.empty()) info.odd.push_back("It holds no vertices.");
  if (size.maxCoeff() > 200)
    info.odd.push_back("It is larger than 200 m: its unit may be the millimetre or centimetre.");
  if (!mesh.empty() && size.maxCoeff() < 0.01)
    info.odd.push_back("It is smaller than 1 cm: its unit may be larger than the metre.");
  return info;
}

}  // namespace plumbline
