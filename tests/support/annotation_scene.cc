// SPDX-License-Identifier: Apache-2.0
#include "tests/support/annotation_scene.h"

#include <fstream>
#include <numbers>

#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/geometry/surface_sampling.h"
#include "engine/models/mesh_file.h"
#include "tests/support/furniture_models.h"

namespace plumbline {
namespace {

void WriteDatabase(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  nlohmann::json list = nlohmann::json::array();
  const auto database = MakeFurnitureDatabase();
  for (const CadModel& model : database->models()) {
    PLB_CHECK(WritePly(folder / (model.name + ".ply"), model.mesh).ok());
    list.push_back({{"name", model.name},
                    {"file", model.name + ".ply"},
                    {"category", model.category},
                    {"symmetry", {{"axis", {0, 0, 1}}, {"order", model.symmetry.order}}},
                    {"support", model.support == Support::kFloor ? "floor" : "any"}});
  }
  std::ofstream(folder / "models.json") << nlohmann::json{{"units", "m"}, {"models", list}}.dump(1);
}

Eigen::Isometry3d Standing(double x, double y, double azimuth_deg) {
  return Eigen::Translation3d(x, y, 0) *
         Eigen::AngleAxisd(azimuth_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitZ());
}

void AddObject(const CadModel& model, const Eigen::Isometry3d& scan_from_model,
               TriangleMesh& scan) {
  const auto samples = SampleSurface(model.mesh, 9000, 7).value();
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Eigen::Vector3i& t = model.mesh.triangles[static_cast<std::size_t>(samples.triangles[i])];
    const Eigen::Vector3f a = model.mesh.vertices[static_cast<std::size_t>(t[0])],
                          b = model.mesh.vertices[static_cast<std::size_t>(t[1])],
                          c = model.mesh.vertices[static_cast<std::size_t>(t[2])];
    const Eigen::Vector3d normal = (b - a).cross(c - a).normalized().cast<double>();
    scan.vertices.push_back((scan_from_model * samples.points[i]).cast<float>());
    scan.normals.push_back((scan_from_model.linear() * normal).cast<float>());
    scan.colors.push_back({180, 120, 80});
  }
}

}  // namespace

AnnotationScene MakeAnnotationScene(const std::filesystem::path& folder,
                                    const Eigen::Isometry3d& scan_from_level) {
  AnnotationScene scene;
  scene.scan = folder / "scan.ply";
  scene.models = folder / "models";
  scene.up_in_scan = scan_from_level.linear().col(2);
  scene.scan_from_armchair = scan_from_level * Standing(0.4, 0.3, 50);
  scene.scan_from_table = scan_from_level * Standing(-0.9, -0.2, 10);
  WriteDatabase(scene.models);
  TriangleMesh scan;
  constexpr int kHalf = 110;
  constexpr double kStep_m = 0.018;
  for (int i = -kHalf; i <= kHalf; ++i) {
    for (int j = -kHalf; j <= kHalf; ++j) {
      const Eigen::Vector3d point(kStep_m * i, kStep_m * j, 0);
      scan.vertices.push_back((scan_from_level * point).cast<float>());
      scan.normals.push_back(scene.up_in_scan.cast<float>());
      scan.colors.push_back({150, 150, 145});
    }
  }
  const auto database = MakeFurnitureDatabase();
  AddObject(database->model(*database->Find("armchair")), scene.scan_from_armchair, scan);
  AddObject(database->model(*database->Find("table")), scene.scan_from_table, scan);
  PLB_CHECK(WritePly(scene.scan, scan).ok());
  return scene;
}

}  // namespace plumbline
