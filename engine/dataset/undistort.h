// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/dataset/sequence.h"
#include "engine/geometry/box.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// Edges of the recorded image moved, pixel by pixel, into the pinhole camera, their normals turned
/// along. Where the undistorted image is stretched, lines get gaps of a pixel; no line gets
/// thicker. The same map without distortion.
EdgeMap UndistortEdges(const Camera& camera, const EdgeMap& recorded);

/// The box around the undistorted outline of a box of the recorded image; empty where the pinhole
/// camera sees none of it. The same box without distortion.
Box2 UndistortBox(const Camera& camera, const Box2& recorded);

}  // namespace plumbline
