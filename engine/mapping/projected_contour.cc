// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/projected_contour.h"

#include <algorithm>
#include <cmath>

#include "engine/base/vectorised.h"

namespace plumbline {
namespace {

constexpr int kLanes = 16;  ///< Loops over points go in steps of so many.

/// atan2(y, x) / pi modulo 1, in [0, 1]; absolute error below 1e-4. Branch-free, so that loops
/// vectorise.
inline float HalfTurn(float x, float y) {
  const float ax = x < 0 ? -x : x, ay = y < 0 ? -y : y;
  const float high = ax > ay ? ax : ay, low = ax > ay ? ay : ax;
  const float ratio = low / (high + 1e-20f);
  const float s = ratio * ratio;
  // Minimax polynomial of atan on [0, 1] (Abramowitz and Stegun 4.4.47), over pi.
  float turn = ratio * (0.3182553f +
                        s * (-0.1051444f + s * (0.0573527f + s * (-0.0270981f + s * 0.0066322f))));
  turn = ay > ax ? 0.5f - turn : turn;
  return (x < 0) != (y < 0) ? 1.0f - turn : turn;
}

int WholeLanes(int points) { return (points + kLanes - 1) / kLanes * kLanes; }

inline int BinOf(float turn) {
  return static_cast<int>(turn * OrientedTable::kBins) & (OrientedTable::kBins - 1);
}

/// `count` points from the one at `begin` on.
inline __attribute__((always_inline)) void ProjectStretch(const ContourView& contour,
                                                          const ContourProjection& p, int begin,
                                                          int count, float* __restrict u,
                                                          float* __restrict v, float* __restrict z,
                                                          float* __restrict turn) {
  for (int i = begin; i < begin + count; ++i) {
    const float px = contour.x[i], py = contour.y[i], pz = contour.z[i];
    const float qx = p.r[0][0] * px + p.r[0][1] * py + p.r[0][2] * pz + p.t[0];
    const float qy = p.r[1][0] * px + p.r[1][1] * py + p.r[1][2] * pz + p.t[1];
    const float qz = p.r[2][0] * px + p.r[2][1] * py + p.r[2][2] * pz + p.t[2];
    const float inverse = 1.0f / (qz > 1e-3f ? qz : 1e-3f);
    const float bx = qx * inverse, by = qy * inverse;
    const float mx = contour.nx[i], my = contour.ny[i], mz = contour.nz[i];
    const float dx = p.r[0][0] * mx + p.r[0][1] * my + p.r[0][2] * mz;
    const float dy = p.r[1][0] * mx + p.r[1][1] * my + p.r[1][2] * mz;
    const float dz = p.r[2][0] * mx + p.r[2][1] * my + p.r[2][2] * mz;
    u[i] = p.fx * bx + p.cx;
    v[i] = p.fy * by + p.cy;
    z[i] = qz;
    turn[i] = HalfTurn(p.fx * (dx - dz * bx), p.fy * (dy - dz * by));
  }
}

PLUMBLINE_VECTORISED
void ProjectPoints(const ContourView& contour, const ContourProjection& projection,
                   ProjectedContour& points) {
  const ContourProjection p = projection;
  const ContourView view = contour;
  int i = 0;
  for (; i + kLanes <= view.size; i += kLanes)
    ProjectStretch(view, p, i, kLanes, points.u, points.v, points.z, points.turn);
  // The last of them overlap, so that none is projected by itself.
  if (i < view.size && view.size >= kLanes)
    ProjectStretch(view, p, view.size - kLanes, kLanes, points.u, points.v, points.z, points.turn);
  else
    ProjectStretch(view, p, i, view.size - i, points.u, points.v, points.z, points.turn);
}

PLUMBLINE_VECTORISED
void FindOutwards(const ContourView& contour, const ContourProjection& projection, int end,
                  ProjectedContour& points) {
  const ContourProjection p = projection;
  for (int i = 0; i < end; ++i) {
    const float x = contour.nx[i], y = contour.ny[i], z = contour.nz[i];
    const float along_ray = p.r[2][0] * x + (p.r[2][1] * y + p.r[2][2] * z);
    const float u =
        p.fx * (p.r[0][0] * x + (p.r[0][1] * y + p.r[0][2] * z)) - along_ray * (points.u[i] - p.cx);
    const float v =
        p.fy * (p.r[1][0] * x + (p.r[1][1] * y + p.r[1][2] * z)) - along_ray * (points.v[i] - p.cy);
    points.outwards_u[i] = u;
    points.outwards_v[i] = v;
  }
}

PLUMBLINE_VECTORISED
void FindSidesOf(ProjectedContour& points) {
  const int end = points.outline_lanes_end;
  for (int i = 0; i < end; ++i) {
    const float u = points.outwards_u[i], v = points.outwards_v[i];
    const float across = u < 0 ? -u : u, down = v < 0 ? -v : v;
    const int sideways = u > 0 ? 0 : 2, upright = v > 0 ? 1 : 3;
    points.side[i] = across > down ? sideways : upright;
  }
}

PLUMBLINE_VECTORISED
void MoveOutwards(const std::array<double, 4>& offsets_px, ProjectedContour& points) {
  const float right = static_cast<float>(offsets_px[0]), below = static_cast<float>(offsets_px[1]),
              left = static_cast<float>(offsets_px[2]), above = static_cast<float>(offsets_px[3]);
  const int outline = points.outline_size, end = points.outline_lanes_end;
  for (int i = 0; i < end; ++i) {
    const float u = points.outwards_u[i], v = points.outwards_v[i];
    const float length = std::sqrt(u * u + v * v);
    const int side = points.side[i];
    const float sideways = side == 0 ? right : left, upright = side == 1 ? below : above;
    const float offset_px = (side & 1) == 0 ? sideways : upright;
    const float factor = length > 0 ? offset_px / length : 0;
    const float moved_u = points.u[i] + factor * u, moved_v = points.v[i] + factor * v;
    points.u[i] = i < outline ? moved_u : points.u[i];
    points.v[i] = i < outline ? moved_v : points.v[i];
  }
}

PLUMBLINE_VECTORISED
void MoveAll(float x_px, float y_px, ProjectedContour& points) {
  const int end = points.lanes_end;
  for (int i = 0; i < end; ++i) {
    points.u[i] += x_px;
    points.v[i] += y_px;
  }
}

PLUMBLINE_VECTORISED
void FindCells(float near_m, int width, int height, ProjectedContour& points) {
  const float right = static_cast<float>(width), bottom = static_cast<float>(height);
  const int end = points.lanes_end;  // A copy, which no cell that is written may change.
  for (int i = 0; i < end; ++i) {
    // Pixel centres are at integers: pixel 0 spans [-0.5, 0.5).
    const float u = points.u[i] + 0.5f, v = points.v[i] + 0.5f;
    const bool inside = (points.z[i] >= near_m) & (u >= 0) & (v >= 0) & (u < right) & (v < bottom);
    const int x = static_cast<int>(inside ? u : 0.0f), y = static_cast<int>(inside ? v : 0.0f);
    points.cell[i] = inside ? (BinOf(points.turn[i]) * height + y) * width + x : -1;
  }
}

/// What of an image that is smaller than the camera's belongs to a pixel of it.
struct SmallerImage {
  float scale_x, scale_y;
  float last_x, last_y;
  int stride;
};

/// Finds the pixel of the smaller image at each point, or next to a point beside it.
PLUMBLINE_VECTORISED
void FindPixels(const SmallerImage& image, const ProjectedContour& points, std::int32_t* pixels) {
  const SmallerImage at = image;
  const int end = points.lanes_end;
  for (int i = 0; i < end; ++i) {
    float u = (points.u[i] + 0.5f) * at.scale_x, v = (points.v[i] + 0.5f) * at.scale_y;
    u = u > 0 ? u : 0;
    v = v > 0 ? v : 0;
    u = u < at.last_x ? u : at.last_x;
    v = v < at.last_y ? v : at.last_y;
    pixels[i] = static_cast<int>(v) * at.stride + static_cast<int>(u);
  }
}

PLUMBLINE_VECTORISED
void HideBehind(const float* in_front, float margin_m, ProjectedContour& points) {
  const int end = points.lanes_end;
  for (int i = 0; i < end; ++i) {
    const bool hidden = (in_front[i] > 0) & (in_front[i] < points.z[i] - margin_m);
    points.cell[i] = hidden ? -1 : points.cell[i];
  }
}

/// What an image of the camera's view, which is `width` x `height` pixels large, has at each point.
void LookUp(const cv::Mat& image, int width, int height, const ProjectedContour& points,
            float* values) {
  alignas(64) std::int32_t pixels[ProjectedContour::kMaxPoints];
  FindPixels({static_cast<float>(image.cols) / static_cast<float>(width),
              static_cast<float>(image.rows) / static_cast<float>(height),
              static_cast<float>(image.cols - 1), static_cast<float>(image.rows - 1),
              static_cast<int>(image.step1())},
             points, pixels);
  const float* first = image.ptr<float>();
  for (int i = 0; i < points.lanes_end; ++i) values[i] = first[pixels[i]];
}

PLUMBLINE_VECTORISED
void LeaveOutAlike(const float* behind, const float* luminance, float least_contrast,
                   ProjectedContour& points) {
  const int outline = points.outline_size, end = points.outline_lanes_end;
  for (int i = 0; i < end; ++i) {
    const float contrast = behind[i] - luminance[i];
    const bool alike = (i < outline) & (contrast < least_contrast) & (contrast > -least_contrast);
    points.cell[i] = alike ? -1 : points.cell[i];
    points.hit[i] = alike ? 0 : points.hit[i];
  }
}

/// Where the edge along the rim of each point of the outline would be: of points without, -1.
struct Rims {
  alignas(64) std::int32_t cell[ProjectedContour::kMaxPoints];
  alignas(64) float weight[ProjectedContour::kMaxPoints];
  alignas(64) std::int32_t hit[ProjectedContour::kMaxPoints];
};

PLUMBLINE_VECTORISED
void FindRims(const float* rim, int width, int height, const ProjectedContour& points, Rims& rims) {
  const float right = static_cast<float>(width), bottom = static_cast<float>(height);
  const int outline = points.outline_size, end = points.outline_lanes_end;
  for (int i = 0; i < end; ++i) {
    const float inwards = -rim[i] / points.z[i];
    const float du = inwards * points.outwards_u[i], dv = inwards * points.outwards_v[i];
    const float weight = RimWeight(std::sqrt(du * du + dv * dv));
    const float u = points.u[i] + du + 0.5f, v = points.v[i] + dv + 0.5f;
    const bool counts = (i < outline) & (rim[i] > 0) & (points.cell[i] >= 0) & (weight > 0) &
                        (u >= 0) & (v >= 0) & (u < right) & (v < bottom);
    const float x = counts ? u : 0.0f, y = counts ? v : 0.0f;
    const int cell =
        (BinOf(points.turn[i]) * height + static_cast<int>(y)) * width + static_cast<int>(x);
    rims.cell[i] = counts ? cell : -1;
    rims.weight[i] = weight;
  }
}

void LookUp(const std::uint8_t* table, const std::int32_t* cells, int end, std::int32_t* hits) {
  for (int i = 0; i < end; ++i) {
    const int cell = cells[i], seen = cell >= 0 ? -1 : 0;
    hits[i] = table[cell & seen] & seen;
  }
}

PLUMBLINE_VECTORISED
void RaiseHits(const Rims& rims, ProjectedContour& points) {
  const int end = points.outline_lanes_end;
  for (int i = 0; i < end; ++i) {
    const float weighted = rims.cell[i] >= 0 ? rims.weight[i] * static_cast<float>(rims.hit[i]) : 0;
    const int below = static_cast<int>(weighted);
    const int hit = weighted - static_cast<float>(below) >= 0.5f ? below + 1 : below;
    points.hit[i] = hit > points.hit[i] ? hit : points.hit[i];
  }
}

PLUMBLINE_VECTORISED
ContourTally TallyOf(const ProjectedContour& points, int begin, int end) {
  int hits = 0, seen = 0;
  for (int i = begin; i < end; ++i) {
    hits += points.hit[i];
    seen += points.cell[i] >= 0 ? 1 : 0;
  }
  return {hits, seen};
}

PLUMBLINE_VECTORISED
std::array<ContourTally, 4> TallyOfSides(const ProjectedContour& points) {
  int hits[4] = {}, seen[4] = {};
  const int end = points.outline_size;
  for (int i = 0; i < end; ++i) {
    for (int side = 0; side < 4; ++side) {
      const bool is = points.side[i] == side;
      hits[side] += is ? points.hit[i] : 0;
      seen[side] += (is & (points.cell[i] >= 0)) ? 1 : 0;
    }
  }
  return {{{hits[0], seen[0]}, {hits[1], seen[1]}, {hits[2], seen[2]}, {hits[3], seen[3]}}};
}

PLUMBLINE_VECTORISED
ContourBoxes FindBoundsFrom(float near_m, const ProjectedContour& points) {
  constexpr int kBeside = 8;  // More bounds would not stay in registers.
  constexpr float kNone = std::numeric_limits<float>::max();
  alignas(32) float bounds[8][kBeside];
  for (int k = 0; k < kBeside; ++k) {
    for (int b = 0; b < 8; ++b) bounds[b][k] = b % 4 < 2 ? kNone : -kNone;
  }
  for (int i = 0; i < points.lanes_end; i += kBeside) {
    for (int k = 0; k < kBeside; ++k) {
      const float u = points.u[i + k], v = points.v[i + k];
      const bool in_front = points.z[i + k] >= near_m, seen = points.cell[i + k] >= 0;
      const float low[4] = {in_front ? u : kNone, in_front ? v : kNone, seen ? u : kNone,
                            seen ? v : kNone};
      const float high[4] = {in_front ? u : -kNone, in_front ? v : -kNone, seen ? u : -kNone,
                             seen ? v : -kNone};
      bounds[0][k] = low[0] < bounds[0][k] ? low[0] : bounds[0][k];
      bounds[1][k] = low[1] < bounds[1][k] ? low[1] : bounds[1][k];
      bounds[2][k] = high[0] > bounds[2][k] ? high[0] : bounds[2][k];
      bounds[3][k] = high[1] > bounds[3][k] ? high[1] : bounds[3][k];
      bounds[4][k] = low[2] < bounds[4][k] ? low[2] : bounds[4][k];
      bounds[5][k] = low[3] < bounds[5][k] ? low[3] : bounds[5][k];
      bounds[6][k] = high[2] > bounds[6][k] ? high[2] : bounds[6][k];
      bounds[7][k] = high[3] > bounds[7][k] ? high[3] : bounds[7][k];
    }
  }
  const auto least = [&](int b) { return *std::min_element(bounds[b], bounds[b] + kBeside); };
  const auto most = [&](int b) { return *std::max_element(bounds[b], bounds[b] + kBeside); };
  return {{least(0), least(1), most(2), most(3)}, {least(4), least(5), most(6), most(7)}};
}

}  // namespace

void Project(const ContourView& contour, const ContourProjection& p, ProjectedContour& points) {
  ProjectPoints(contour, p, points);
  points.size = contour.size;
  points.outline_size = contour.outline_size;
  points.lanes_end = WholeLanes(contour.size);
  points.outline_lanes_end = std::min(WholeLanes(contour.outline_size), contour.size);
  for (int i = contour.size; i < points.lanes_end; ++i)
    points.u[i] = points.v[i] = points.turn[i] = 0, points.z[i] = -1;
}

void FindNormals(const ContourView& contour, const ContourProjection& p, ProjectedContour& points) {
  FindOutwards(contour, p, contour.size, points);
}

void FindSides(const ContourView& contour, const ContourProjection& p, ProjectedContour& points) {
  FindOutwards(contour, p, points.outline_lanes_end, points);
  FindSidesOf(points);
}

void Widen(const ContourView& contour, const ContourProjection& p,
           const std::array<double, 4>& offsets_px, ProjectedContour& points) {
  FindSides(contour, p, points);
  MoveOutwards(offsets_px, points);
}

void Move(float x_px, float y_px, ProjectedContour& points) { MoveAll(x_px, y_px, points); }

void CopyPoints(const ProjectedContour& points, ProjectedContour& copy) {
  copy.size = points.size;
  copy.outline_size = points.outline_size;
  copy.lanes_end = points.lanes_end;
  copy.outline_lanes_end = points.outline_lanes_end;
  for (const auto array :
       {&ProjectedContour::u, &ProjectedContour::v, &ProjectedContour::z, &ProjectedContour::turn})
    std::copy_n(points.*array, points.lanes_end, copy.*array);
}

void FindHits(const ScoringView& view, const ContourView& contour, const ContourProjection& p,
              ProjectedContour& points) {
  const OrientedTable& table = *view.table;
  FindCells(static_cast<float>(view.near_m), table.width(), table.height(), points);
  if (!view.occluder_depth.empty()) {
    alignas(64) float in_front[ProjectedContour::kMaxPoints];
    LookUp(view.occluder_depth, table.width(), table.height(), points, in_front);
    HideBehind(in_front, static_cast<float>(view.occlusion_margin_m), points);
  }
  LookUp(table.cells(), points.cell, points.size, points.hit);
  if (!view.rims) return;
  static thread_local Rims rims;
  FindOutwards(contour, p, points.outline_lanes_end, points);
  FindRims(contour.rim, table.width(), table.height(), points, rims);
  LookUp(table.cells(), rims.cell, points.outline_lanes_end, rims.hit);
  RaiseHits(rims, points);
}

void LeaveOutUncontrasted(const ScoringView& view, const ContourView& contour,
                          ProjectedContour& points) {
  if (view.luminance_behind.empty() || view.least_contrast <= 0) return;
  alignas(64) float behind[ProjectedContour::kMaxPoints];
  LookUp(view.luminance_behind, view.table->width(), view.table->height(), points, behind);
  LeaveOutAlike(behind, contour.luminance, static_cast<float>(view.least_contrast), points);
}

ContourTally TallyOutline(const ProjectedContour& points) {
  return TallyOf(points, 0, points.outline_size);
}

ContourTally TallyInnerLines(const ProjectedContour& points) {
  return TallyOf(points, points.outline_size, points.size);
}

std::array<ContourTally, 4> TallySides(const ProjectedContour& points) {
  return TallyOfSides(points);
}

Box2 ContourBounds::Clipped(const PinholeCamera& camera) const {
  if (x1 < x0) return {};
  return Intersection({x0, y0, x1, y1}, {0, 0, static_cast<float>(camera.width - 1),
                                         static_cast<float>(camera.height - 1)});
}

ContourBoxes FindBoxes(double near_m, const ProjectedContour& points) {
  return FindBoundsFrom(static_cast<float>(near_m), points);
}

}  // namespace plumbline
