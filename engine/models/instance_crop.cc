// SPDX-License-Identifier: Apache-2.0
#include "engine/models/instance_crop.h"

#include <string>
#include <utility>

#include "engine/base/files.h"
#include "engine/geometry/gravity.h"
#include "engine/models/ply_file.h"

namespace plumbline {

Result<LabelledMesh> ReadLabelledMesh(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFile(file);
  if (!bytes.ok()) return bytes.error();
  LabelledMesh scan;
  Result<TriangleMesh> mesh = ParsePly(*bytes, file, nullptr, &scan.labels);
  if (!mesh.ok()) return mesh.error();
  scan.mesh = std::move(*mesh);
  if (scan.labels.size() != scan.mesh.vertices.size())
    return Error{ErrorCode::kInvalidInput,
                 "'" + file.string() + "' has vertices without a property 'label'"};
  return scan;
}

TriangleMesh CropByLabel(const LabelledMesh& scan, int label) {
  const TriangleMesh& all = scan.mesh;
  TriangleMesh crop;
  std::vector<int> place(all.vertices.size(), -1);
  const auto kept = [&](int vertex) {
    const auto v = static_cast<std::size_t>(vertex);
    if (place[v] < 0) {
      place[v] = static_cast<int>(crop.vertices.size());
      crop.vertices.push_back(all.vertices[v]);
      if (!all.normals.empty()) crop.normals.push_back(all.normals[v]);
      if (!all.colors.empty()) crop.colors.push_back(all.colors[v]);
    }
    return place[v];
  };
  for (const Eigen::Vector3i& t : all.triangles) {
    bool inside = true;
    for (int corner = 0; corner < 3; ++corner)
      inside = inside && scan.labels[static_cast<std::size_t>(t[corner])] == label;
    if (inside) crop.triangles.emplace_back(kept(t[0]), kept(t[1]), kept(t[2]));
  }
  return crop;
}

UprightCrop UprightModel(const TriangleMesh& crop, const Eigen::Vector3d& gravity_in_scan) {
  UprightCrop model;
  model.scan_from_object.linear() = UprightFrame(gravity_in_scan).upright_rotation();
  model.mesh = Transformed(crop, model.scan_from_object.inverse());
  const Eigen::AlignedBox3f box = BoundingBox(model.mesh);
  if (box.isEmpty()) return model;
  Eigen::Vector3d foot = box.center().cast<double>();
  foot.z() = box.min().z();
  model.scan_from_object.translation() = model.scan_from_object.linear() * foot;
  model.mesh = Transformed(crop, model.scan_from_object.inverse());
  return model;
}

}  // namespace plumbline
