// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/bop_models.h"

#include <cstdio>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/geometry/diameter.h"
#include "engine/models/model_texture.h"

namespace plumbline {
namespace {

nlohmann::json ModelInfo(const CadModel& model) {
  const Eigen::Vector3d center = model.center(), size = model.bounds.sizes().cast<double>();
  nlohmann::json info = {{"diameter", kBopUnitsPerMetre * Diameter(model.mesh)}};
  const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    info[std::string("min_") + axes[i]] = -0.5 * kBopUnitsPerMetre * size[i];
    info[std::string("size_") + axes[i]] = kBopUnitsPerMetre * size[i];
  }
  const Symmetry& symmetry = model.symmetry;
  if (symmetry.order == 0) {
    info["symmetries_continuous"] = {
        {{"axis", {symmetry.axis.x(), symmetry.axis.y(), symmetry.axis.z()}},
         {"offset", BopVector(-center)}}};
  }
  for (int i = 1; i < symmetry.order; ++i) {
    Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
    turn.topLeftCorner<3, 3>() =
        Eigen::AngleAxisd(2 * std::numbers::pi * i / symmetry.order, symmetry.axis.normalized())
            .toRotationMatrix();
    turn.topRightCorner<3, 1>() =
        kBopUnitsPerMetre * (turn.topLeftCorner<3, 3>() * center - center);
    nlohmann::json rows = nlohmann::json::array();
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) rows.push_back(turn(r, c));
    }
    info["symmetries_discrete"].push_back(rows);
  }
  return info;
}

/// What a vertex has besides its place and its normal.
struct PlyLook {
  bool colors = false;
  std::string texture;  ///< A file beside it.
};

std::string PlyHeader(const TriangleMesh& mesh, const PlyLook& look) {
  std::string text = "ply\nformat ascii 1.0\ncomment millimetres\n";
  if (!look.texture.empty()) text += "comment TextureFile " + look.texture + "\n";
  text += fmt::format("element vertex {}\n", mesh.vertices.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
    text += fmt::format("property float {}\n", name);
  if (look.colors) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (!look.texture.empty()) text += "property float texture_u\nproperty float texture_v\n";
  return text + fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                            mesh.triangles.size());
}

std::string PlyText(const CadModel& model, const PlyLook& look) {
  TriangleMesh mesh = model.mesh;
  if (mesh.normals.empty()) ComputeNormals(mesh);
  std::string text = PlyHeader(mesh, look);
  char line[160];
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d v =
        kBopUnitsPerMetre * (mesh.vertices[i].cast<double>() - model.center());
    const Eigen::Vector3f& n = mesh.normals[i];
    std::snprintf(line, sizeof(line), "%.6g %.6g %.6g %.5g %.5g %.5g", v.x(), v.y(), v.z(), n.x(),
                  n.y(), n.z());
    text += line;
    if (look.colors) {
      const auto& [red, green, blue] = mesh.colors[i];
      text += fmt::format(" {} {} {}", red, green, blue);
    }
    if (!look.texture.empty()) {
      const Eigen::Vector2f& uv = mesh.texture_coordinates[i];
      text += fmt::format(" {:.6g} {:.6g}", uv.x(), uv.y());
    }
    text += '\n';
  }
  for (const Eigen::Vector3i& t : mesh.triangles)
    text += fmt::format("3 {} {} {}\n", t.x(), t.y(), t.z());
  return text;
}

/// The mesh, and its texture beside it.
Status WriteModel(const ModelDatabase& models, const CadModel& model,
                  const std::filesystem::path& folder) {
  const std::string name = fmt::format("obj_{:06d}", model.id.value + 1);
  PlyLook look{.colors = !model.mesh.colors.empty(), .texture = ""};
  if (const std::filesystem::path texture = TextureOf(models, model); !texture.empty()) {
    look.texture = name + texture.extension().string();
    const Result<std::string> picture = ReadFile(texture);
    if (!picture) return picture.error();
    const Status copied = WriteFileAtomically(folder / look.texture, *picture);
    if (!copied.ok()) return copied;
  }
  return WriteFileAtomically(folder / (name + ".ply"), PlyText(model, look));
}

}  // namespace

nlohmann::json BopVector(const Eigen::Vector3d& v) {
  return {kBopUnitsPerMetre * v.x(), kBopUnitsPerMetre * v.y(), kBopUnitsPerMetre * v.z()};
}

Status WriteBopModels(const ModelDatabase& models, const std::set<int>& used,
                      const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo, "cannot make '" + folder.string() + "': " + error.message()};
  }
  nlohmann::json infos = nlohmann::json::object(), names = nlohmann::json::object();
  for (const int i : used) {
    const CadModel& model = models.model(ModelId{i});
    const std::string id = std::to_string(i + 1);
    infos[id] = ModelInfo(model);
    const Eigen::Vector3d center = model.center();
    names[id] = {{"name", model.name},
                 {"category", model.category},
                 {"center_m", {center.x(), center.y(), center.z()}}};
    if (const Status written = WriteModel(models, model, folder); !written.ok()) return written;
  }
  const Status written = WriteJson(folder / "models_info.json", infos);
  return written.ok() ? WriteJson(folder / "plumbline_models.json", names) : written;
}

}  // namespace plumbline
