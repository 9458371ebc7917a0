// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/geometry/box.h"
#include "engine/render/renderer.h"

namespace plumbline {

struct AtlasOptions {
  int tile_px = 128;       ///< Size of the picture that each hypothesis gets; a multiple of 16.
  int tiles_per_row = 16;  ///< tiles_per_row^2 hypotheses are drawn and scored at a time.
  double contour_step_m = 0.04;  ///< As of RenderOptions; at most 0.3 bounding radii of a mesh.
  double inner_weight = 0.5;     ///< Creases and marks: as of ViewpointModelOptions.
  double crease_angle_deg = 40, mark_contrast = 0.15;
};

/// A mesh of the atlas at a pose, so many times as large as it is.
struct AtlasHypothesis {
  int mesh = -1;
  Eigen::Isometry3d cam_from_object = Eigen::Isometry3d::Identity();
  double scale = 1;
};

/// The image that hypotheses are scored in.
struct AtlasView {
  PinholeCamera camera;
  /// For every pixel (row by row) 16 hits in 0 .. 255, one for each range [k, k + 1) * pi / 16 of
  /// the contour normal's direction: an OrientedTable's data.
  std::span<const std::uint8_t> hits;
  double chance = 0;  ///< Mean hit / 255.
  /// Z [m] of what may hide the object, CV_32F, 0 none, of any size; empty: nothing hides it.
  cv::Mat occluder_depth;
  double occlusion_margin_m = 0.05;
  double near_m = 0.15;
};

/// What the reduction gives for one hypothesis: lengths of contour [m] as seen at the depth of the
/// mesh's centre, boxes [px] clipped to the image.
struct AtlasScore {
  float agreement_m = 0;  ///< Sum of (hit - chance) * length over visible samples.
  float visible_m = 0, total_m = 0;
  int visible_samples = 0;
  Box2 whole_box, visible_box;
};

/// The reference scorer's hands: draws many hypotheses in one call, each into its own tile by a
/// camera that looks at the mesh's centre, finds their contours with normals and sums up what they
/// hit, all in GLSL; a few floats a hypothesis come back. Deterministic on one machine. Use and
/// destroy it in the thread of its context.
class HypothesisAtlas {
 public:
  /// The context must outlive the atlas. Errors: kUnsupported without compute shaders (OpenGL 4.3).
  static Result<std::unique_ptr<HypothesisAtlas>> Create(RenderContext& context,
                                                         const AtlasOptions& options);
  virtual ~HypothesisAtlas() = default;
  /// Uploads a mesh once; the handle is valid as long as the atlas.
  virtual int AddMesh(const TriangleMesh& mesh) = 0;
  /// `scores` is as long as `hypotheses`.
  virtual void Score(const AtlasView& view, std::span<const AtlasHypothesis> hypotheses,
                     std::span<AtlasScore> scores) = 0;
};

}  // namespace plumbline
