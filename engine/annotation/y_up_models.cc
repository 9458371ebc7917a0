// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/y_up_models.h"

#include <cstdio>

namespace plumbline {

Eigen::Isometry3d ObjectFromYUp() {
  Eigen::Isometry3d object_from_y_up = Eigen::Isometry3d::Identity();
  object_from_y_up.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return object_from_y_up;
}

std::string YUpObj(const TriangleMesh& mesh) {
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

}  // namespace plumbline
