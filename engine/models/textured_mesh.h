// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/geometry/mesh.h"
#include "engine/models/file_frame.h"

namespace plumbline {

/// A mesh as its file has it.
struct TexturedMesh {
  /// Units and axes as in the file. What it looks like are its colours times the texture's; a PLY
  /// has either. `texture_file` names `texture` if that is one file's as it is.
  TriangleMesh mesh;
  /// CV_8UC3, BGR; empty without. Texture coordinates have their origin in its lower left corner,
  /// (1, 1) in the upper right, and beyond these it repeats.
  cv::Mat texture;
  FileFrame frame;
  std::vector<std::string> warnings;  ///< Sentences: what was left out.
};

/// The colours of a surface that has several textures, or parts without one.
struct TexturePart {
  TriangleMesh mesh;
  int texture = -1;  ///< Of the textures; -1: it has its own colours or none.
};

/// One texture for all parts: each is copied into it as far as its coordinates reach (repeating
/// where they go beyond it), smaller if need be; parts without become a spot in white, with their
/// own colours in the vertices. Parts that differ in having normals lose them.
TexturedMesh JoinParts(std::vector<TexturePart> parts, const std::vector<cv::Mat>& textures);

/// A picture from the bytes of its file (PNG, JPEG, ..), CV_8UC3; empty if it is none. Without its
/// colour profile, about which libpng has much to say.
cv::Mat DecodePicture(std::string bytes);

/// The texture at one point, between the centres of its texels; RGB, 0 .. 255.
Eigen::Vector3f TexelAt(const cv::Mat& texture, const Eigen::Vector2f& coordinates);

/// Colours for the vertices of a mesh with a texture: what its faces show near each of them. For
/// meshes whose faces are small beside what is drawn on them, as those of scans.
void PaintVertices(const cv::Mat& texture, TriangleMesh& mesh);

/// The same after the faces were cut where the texture changes, so that its lines are lines of
/// vertices: until what is left could make no mark (steps of luminance under 0.075) or is smaller
/// than a pixel of the views that look for marks (0.6 % of the diagonal), the worst first, to at
/// most `faces` faces. The surface stays as it is; normals are dropped.
void PaintByTexture(const cv::Mat& texture, int faces, TriangleMesh& mesh);

}  // namespace plumbline
