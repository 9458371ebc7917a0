// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/geometry/mesh.h"

namespace plumbline {

/// The largest distance of two vertices [m], in time that grows with the square of their number; 0
/// without any.
double Diameter(const TriangleMesh& mesh);

}  // namespace plumbline
