// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/sensor/camera.h"
#include "engine/vio/filter_state.h"

namespace plumbline {

/// What the filter may refine of a camera.
LensVector LensOf(const Camera& camera);
/// The camera with these numbers; a fifth coefficient of the distortion, and what its model lacks,
/// stay.
Camera WithLens(Camera camera, const LensVector& lens);

/// One number of a lens as people read it.
struct LensEntry {
  const char* name;
  const char* key;  ///< In JSON, in the LensVector's unit.
  const char* unit;
  double factor = 1;  ///< From the LensVector's unit to `unit`.
  int digits = 0;     ///< Behind the point.
};
/// @param row  Of a LensVector.
LensEntry LensEntryOf(int row);

}  // namespace plumbline
