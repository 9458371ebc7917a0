// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/geometry/mesh.h"
#include "engine/models/file_frame.h"

namespace plumbline {

/// What one sees of a mesh from far away in one direction, in a picture of 128 pixels.
struct SideView {
  double shape_lines = 0;  ///< Pixels where depth or slope jump, of those that show the mesh.
  double color_lines = 0;  ///< Pixels of one surface where its colours change.
  double flat_share = 0;  ///< In one plane across the line of sight (within 1.5 % of the diagonal).
};

/// From the side of `toward_eye`; `up` is another axis.
SideView LookFrom(const TriangleMesh& mesh, const SignedAxis& toward_eye, const SignedAxis& up);

}  // namespace plumbline
