// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/geometry/box.h"
#include "engine/geometry/gravity.h"
#include "engine/sensor/camera.h"
#include "engine/vision/oriented_table.h"

namespace plumbline {

/// A shape at an upright pose. `center` is where the centre of its bounding box is.
struct PoseHypothesis {
  ModelId label;
  double azimuth_rad = 0;
  Eigen::Vector3d center_in_world{0, 0, 0};
  double log_scale = 0;

  /// How many times as large as its model it is, about the origin of `object`:
  /// point_in_world = world_from_object * (scale * point_in_object).
  double scale() const { return std::exp(log_scale); }
};

/// By how much all of an object may be elsewhere in an image, and how likely that is.
struct ImageShift {
  double x_px = 0, y_px = 0;
  double weight = 1;  ///< Of all shifts of a view they sum to one.
};

/// One image that hypotheses are scored in.
struct ScoringView {
  PinholeCamera camera;
  Eigen::Isometry3d cam_from_world = Eigen::Isometry3d::Identity();
  const OrientedTable* table = nullptr;  ///< Of the camera's image size.
  /// Z [m] of the nearest surface that may hide the object (not its own); 0 none. Empty: nothing
  /// hides it. May be smaller than the image.
  cv::Mat occluder_depth;
  double occlusion_margin_m =
      0.05;  ///< A point hides only behind a surface at least this much nearer.
  /// Luminance, 0 .. 1, of what is known to be behind the object; elsewhere any other number. The
  /// outline of what looks like that (by less than `least_contrast`) has no edges there: it counts
  /// neither as found nor as missed. Empty: nothing is known. May be smaller than the image.
  cv::Mat luminance_behind;
  double least_contrast = 0;
  double near_m = 0.15;     ///< Nearer points are not seen.
  bool inner_lines = true;  ///< Creases and marks count too.
  /// An edge along a rim of the outline counts for it where they are too close to be told apart
  /// (ContourPoint::rim): tells where an object stands, not whether it is there.
  bool rims = false;
  /// How far outside of the outline the edges are looked for, where it faces right, down, left and
  /// up in the image [px].
  std::array<double, 4> outline_offsets_px = {};
  /// Where the image may be instead, as its pose errs (Evaluate marginalises over them; Score()
  /// looks where the pose says). Empty: there.
  std::vector<ImageShift> shifts = {};
};

/// How a hypothesis' contour agrees with the edges, before normalisation
/// (docs/algorithms/semantic_filter.md): contour samples that are inside the image and not hidden
/// each give (hit - chance) times their length.
struct HypothesisScore {
  float agreement_m = 0;  ///< Sum over visible samples of (hit - chance) * length [m of contour].
  float visible_m = 0;    ///< Length of the contour that can be seen.
  float total_m = 0;      ///< Length of the whole contour.
  Box2 whole_box;         ///< Of the projection, occlusion ignored, clipped to the image [px].
  Box2 visible_box;       ///< Of the visible samples.
};

/// Scores with one side of the outline moved at a time, in the order of `outline_offsets_px`: first
/// each outwards, then each inwards. Boxes may be empty.
using SideScores = std::array<std::vector<HypothesisScore>, 8>;

/// Computes the edge term for many hypotheses. The two implementations compute this same score:
/// from contours rendered for each hypothesis (RenderedScorer, the reference, which knows neither
/// of rims nor of what is behind), and from precomputed ones (ViewpointScorer, fast).
class HypothesisScorer {
 public:
  virtual ~HypothesisScorer() = default;
  /// `scores` is as long as `hypotheses`. Deterministic, whatever the number of threads.
  virtual void Score(const ScoringView& view, const UprightFrame& upright,
                     std::span<const PoseHypothesis> hypotheses,
                     std::span<HypothesisScore> scores) const = 0;
  /// The offsets of the view are replaced. Scores what Score() does with each of eight, which is
  /// what this does unless a scorer knows better.
  virtual SideScores ScoreSides(const ScoringView& view, const UprightFrame& upright,
                                std::span<const PoseHypothesis> hypotheses, double offset_px) const;
  /// With the principal point moved by each shift: scores of all hypotheses for the first, then for
  /// the second, and so on. Boxes may be empty. Scores what Score() does for each, which is what
  /// this does unless a scorer knows better.
  virtual std::vector<HypothesisScore> ScoreShifts(const ScoringView& view,
                                                   const UprightFrame& upright,
                                                   std::span<const PoseHypothesis> hypotheses,
                                                   std::span<const ImageShift> shifts) const;
};

/// The offsets of the `k`th of SideScores.
std::array<double, 4> SideOffsets(std::size_t k, double offset_px);

}  // namespace plumbline
