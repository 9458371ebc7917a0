// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

struct DecimationReport {
  int faces_before = 0, faces_after = 0;
  double mean_error_m =
      0;  ///< Distance between the two surfaces, both ways, over samples uniform by area.
  double max_error_m = 0;
  double mean_color_error = 0;  ///< Grey levels, at those samples; 0 without colours.
};

/// A mesh of at most `faces` faces close to `mesh` (quadric error decimation of the welded
/// geometry; Hoppe 1999 as VTK implements it). Colours and texture coordinates are taken from the
/// nearest point of the source surface; each new face takes its texture coordinates from one chart,
/// so that seams stay seams. Returned unchanged if it has few enough faces. Errors: kDegenerate if
/// the budget cannot be met.
Result<TriangleMesh> DecimateMesh(const TriangleMesh& mesh, int faces, DecimationReport& report);

}  // namespace plumbline
