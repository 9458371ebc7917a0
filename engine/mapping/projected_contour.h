// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "engine/geometry/box.h"
#include "engine/mapping/hypothesis_scorer.h"
#include "engine/sensor/camera.h"
#include "engine/vision/viewpoint_model.h"

namespace plumbline {

/// Projection and image directions in single precision: pixel = (fx X/Z + cx, fy Y/Z + cy).
struct ContourProjection {
  float r[3][3], t[3];  ///< cam_from_object, the object's scale included.
  float fx, fy, cx, cy;
};

/// The points of a contour in an image, array by array, so that loops over them vectorise; filled
/// up to whole lanes with points that do not count.
struct ProjectedContour {
  static constexpr int kMaxPoints = 1024;

  int size = 0, outline_size = 0;  ///< The first are outline, the rest inner lines.
  int lanes_end = 0;
  int outline_lanes_end = 0;  ///< The outline in whole lanes, as far as there are points.
  alignas(64) float u[kMaxPoints], v[kMaxPoints];  ///< [px]
  alignas(64) float z[kMaxPoints];                 ///< [m]
  /// Direction of the normal in the image, in half turns [0, 1].
  alignas(64) float turn[kMaxPoints];
  /// How the point moves in the image as it moves by its normal at a depth of 1.
  alignas(64) float outwards_u[kMaxPoints], outwards_v[kMaxPoints];
  /// Which of ScoringView::outline_offsets_px is of an outline that faces there.
  alignas(64) std::int32_t side[kMaxPoints];
  alignas(64) std::int32_t cell[kMaxPoints];  ///< Of the table; -1 for a point that is not seen.
  alignas(64) std::int32_t hit[kMaxPoints];   ///< What is found there [of 255]; 0 if not seen.
};

void Project(const ContourView& contour, const ContourProjection& p, ProjectedContour& points);

/// Finds `outwards` of each point.
void FindNormals(const ContourView& contour, const ContourProjection& p, ProjectedContour& points);

/// Finds `outwards` and `side` of each point of the outline.
void FindSides(const ContourView& contour, const ContourProjection& p, ProjectedContour& points);

/// Moves the outline outwards in the image, each side of it by its own offset, and keeps which side
/// each point was of.
void Widen(const ContourView& contour, const ContourProjection& p,
           const std::array<double, 4>& offsets_px, ProjectedContour& points);

/// Moves all points in the image.
void Move(float x_px, float y_px, ProjectedContour& points);

/// Another contour of the same points, for which nothing but where they are is found yet.
void CopyPoints(const ProjectedContour& points, ProjectedContour& copy);

/// Finds `cell` and `hit` of each point: nothing where something in front hides it. With `rims`, an
/// edge along the rim of an outline's point counts for it. Changes `outwards`.
void FindHits(const ScoringView& view, const ContourView& contour, const ContourProjection& p,
              ProjectedContour& points);

/// Makes the points of the outline unseen that have no contrast to what is behind them
/// (ScoringView::luminance_behind).
void LeaveOutUncontrasted(const ScoringView& view, const ContourView& contour,
                          ProjectedContour& points);

/// What points of a contour find in the table.
struct ContourTally {
  std::int64_t hits = 0;  ///< [of 255]
  int seen = 0;           ///< Points.
};

ContourTally TallyOutline(const ProjectedContour& points);
ContourTally TallyInnerLines(const ProjectedContour& points);
/// Of each side of the outline by itself.
std::array<ContourTally, 4> TallySides(const ProjectedContour& points);

struct ContourBounds {
  float x0 = std::numeric_limits<float>::max(), y0 = x0, x1 = -x0, y1 = -x0;
  Box2 Clipped(const PinholeCamera& camera) const;
};

/// Box of the points of at least that depth and, of those, of the points that are seen.
struct ContourBoxes {
  ContourBounds whole, seen;
};

ContourBoxes FindBoxes(double near_m, const ProjectedContour& points);

}  // namespace plumbline
