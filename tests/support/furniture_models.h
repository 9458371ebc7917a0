// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/models/model_database.h"

namespace plumbline {

/// Upright cylinder on z = 0 about the z axis, closed.
TriangleMesh MakeCylinder(float radius, float height, int sides);
/// Seat, four legs, two posts and three slats at the back (-x); 0.45 x 0.45 x 0.90 m.
TriangleMesh MakeChair(bool arm_rests);
/// Top and four legs; 1.3 x 0.7 x 0.74 m.
TriangleMesh MakeTable();

/// A few shapes for tests of the mapper: `chair` and `armchair` (category chair), `table` (dining
/// table; two-fold), `crate` (suitcase; may stand anywhere), `vase` (a body of revolution).
std::shared_ptr<const ModelDatabase> MakeFurnitureDatabase();

}  // namespace plumbline
