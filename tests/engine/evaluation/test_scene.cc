// SPDX-License-Identifier: Apache-2.0
#include "tests/engine/evaluation/test_scene.h"

#include <numbers>

namespace plumbline {
namespace {

void AddBox(const Eigen::Vector3d& low, const Eigen::Vector3d& size, int n, TriangleMesh& mesh) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {0.0, 1.0}) {
      const int first = static_cast<int>(mesh.vertices.size());
      for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) {
          Eigen::Vector3d unit;
          unit[axis] = side;
          unit[(axis + 1) % 3] = static_cast<double>(i) / n;
          unit[(axis + 2) % 3] = static_cast<double>(j) / n;
          mesh.vertices.push_back((low + unit.cwiseProduct(size)).cast<float>());
        }
      }
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const int a = first + i * (n + 1) + j, b = a + n + 1;
          mesh.triangles.emplace_back(a, b, b + 1);
          mesh.triangles.emplace_back(a, b + 1, a + 1);
        }
      }
    }
  }
}

CadModel Model(const std::string& name, const std::string& category, int order, TriangleMesh mesh) {
  CadModel model;
  model.name = name;
  model.category = category;
  model.symmetry.order = order;
  model.mesh = std::move(mesh);
  return model;
}

}  // namespace

TriangleMesh BoxMesh(double x, double y, double z, int n) {
  TriangleMesh mesh;
  AddBox({-x / 2, -y / 2, 0}, {x, y, z}, n, mesh);
  return mesh;
}

std::shared_ptr<const ModelDatabase> TestDatabase() {
  TriangleMesh chair = BoxMesh(0.5, 0.45, 0.45);
  AddBox({-0.25, -0.2, 0.45}, {0.06, 0.4, 0.4}, 4,
         chair);  // a back, and a lopsided arm: no symmetry
  AddBox({-0.1, 0.18, 0.45}, {0.3, 0.04, 0.15}, 4, chair);
  return ModelDatabase::FromModels({Model("chair", "chair", 1, chair),
                                    Model("stool", "chair", 4, BoxMesh(0.4, 0.4, 0.5)),
                                    Model("table", "dining table", 2, BoxMesh(1.6, 0.8, 0.75, 12)),
                                    Model("mug", "cup", 0, BoxMesh(0.08, 0.08, 0.1)),
                                    Model("bowl", "cup", 0, BoxMesh(0.15, 0.15, 0.06))});
}

Eigen::Isometry3d UprightPose(double x, double y, double z, double azimuth_deg) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  pose.linear() = Eigen::AngleAxisd(azimuth_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())
                      .toRotationMatrix();
  return pose;
}

GroundTruth TestTruth() {
  GroundTruth truth;
  truth.instances = {{"chair_A", "chair", "chair", UprightPose(1, 0, 0, 30), true},
                     {"chair_B", "chair", "chair", UprightPose(-1, 0.2, 0, -100), true},
                     {"chair_C", "chair", "chair", UprightPose(0.1, 1.2, 0, 180), false},
                     {"table_0", "table", "dining table", UprightPose(0, 0, 0, 5), true},
                     {"mug_0", "mug", "cup", UprightPose(0.3, 0.1, 0.75, 0), false}};
  return truth;
}

std::vector<EstimatedObject> PerfectMap(const GroundTruth& truth) {
  std::vector<EstimatedObject> map;
  for (const GroundTruthInstance& instance : truth.instances) {
    map.push_back({std::to_string(map.size() + 1), instance.model, instance.category,
                   instance.world_from_object});
  }
  return map;
}

}  // namespace plumbline
