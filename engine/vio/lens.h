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

}  // namespace plumbline
