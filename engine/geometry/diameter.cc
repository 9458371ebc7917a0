// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/diameter.h"

#include <algorithm>
#include <cmath>

namespace plumbline {

double Diameter(const TriangleMesh& mesh) {
  float largest = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k)
      largest = std::max(largest, (mesh.vertices[i] - mesh.vertices[k]).squaredNorm());
  }
  return std::sqrt(largest);
}

}  // namespace plumbline
