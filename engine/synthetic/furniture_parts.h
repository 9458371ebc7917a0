// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/synthetic/furniture.h"
#include "engine/synthetic/painted_mesh.h"

namespace plumbline {

/// A straight bar with a rectangular cross-section from the middle of one end to the middle of the
/// other, tapering from `start` to `end` (width along y as far as the bar allows, depth across it).
struct BarShape {
  Eigen::Vector3f from, to;
  Eigen::Vector2f start{0.03f, 0.03f}, end{0.03f, 0.03f};  ///< (depth, width) [m]
  float radius = 0.005f;
};
void AddBar(PaintedMesh& mesh, int paint, const BarShape& shape);

/// A stuffed cushion: a box with wide rounding whose faces bulge by `bulge` of their half
/// thickness.
void AddCushion(PaintedMesh& mesh, int paint, const Eigen::Vector3f& center,
                const Eigen::Vector3f& size, float bulge, const Eigen::Matrix3f& rotation);

/// A box given by its centre and size with the usual small rounding.
void AddBlock(PaintedMesh& mesh, int paint, const Eigen::Vector3f& center,
              const Eigen::Vector3f& size, float radius = 0.004f, int grain = -1);

/// A leaf blade along +x, bent downwards, turned to `azimuth_rad` and raised by `rise_rad`.
/// `divisions`: pieces along it and across.
void AddLeaf(PaintedMesh& mesh, int paint, const Eigen::Vector3f& root, float azimuth_rad,
             float rise_rad, float length, float width, const Eigen::Vector2i& divisions = {7, 2});

/// Moves the mesh so that the centre of its footprint is the origin and it stands on z = 0.
void StandOnOrigin(PaintedMesh& mesh);

}  // namespace plumbline
