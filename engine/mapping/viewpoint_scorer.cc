// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/viewpoint_scorer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/check.h"
#include "engine/base/vectorised.h"

namespace plumbline {
namespace {

constexpr int kMaxPoints = 1024;
constexpr int kLanes = 8;  ///< Loops over points go in steps of so many.

/// The projection of one contour, filled up to whole lanes with points that do not count.
struct Projected {
  alignas(64) float u[kMaxPoints];
  alignas(64) float v[kMaxPoints];
  alignas(64) float z[kMaxPoints];
  alignas(
      64) float turn[kMaxPoints];  ///< Direction of the normal in the image, in half turns [0, 1].
  alignas(64) std::int32_t cell[kMaxPoints];    ///< Of the table; -1 for a point that is not seen.
  alignas(64) std::int32_t before[kMaxPoints];  ///< The pixel of what may hide it.
  int lanes_end = 0;
};

/// Projection and image directions in single precision: pixel = (fx X/Z + cx, fy Y/Z + cy).
struct Projection {
  float r[3][3], t[3];
  float fx, fy, cx, cy;
};

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

PLUMBLINE_VECTORISED
void Project(const ContourView& contour, const Projection& p, Projected& out) {
  for (int i = 0; i < contour.size; ++i) {
    const float x = contour.x[i], y = contour.y[i], z = contour.z[i];
    const float qx = p.r[0][0] * x + p.r[0][1] * y + p.r[0][2] * z + p.t[0];
    const float qy = p.r[1][0] * x + p.r[1][1] * y + p.r[1][2] * z + p.t[1];
    const float qz = p.r[2][0] * x + p.r[2][1] * y + p.r[2][2] * z + p.t[2];
    const float inverse = 1.0f / (qz > 1e-3f ? qz : 1e-3f);
    const float bx = qx * inverse, by = qy * inverse;
    const float mx = contour.nx[i], my = contour.ny[i], mz = contour.nz[i];
    const float dx = p.r[0][0] * mx + p.r[0][1] * my + p.r[0][2] * mz;
    const float dy = p.r[1][0] * mx + p.r[1][1] * my + p.r[1][2] * mz;
    const float dz = p.r[2][0] * mx + p.r[2][1] * my + p.r[2][2] * mz;
    out.u[i] = p.fx * bx + p.cx;
    out.v[i] = p.fy * by + p.cy;
    out.z[i] = qz;
    out.turn[i] = HalfTurn(p.fx * (dx - dz * bx), p.fy * (dy - dz * by));
  }
  out.lanes_end = (contour.size + kLanes - 1) / kLanes * kLanes;
  for (int i = contour.size; i < out.lanes_end; ++i)
    out.u[i] = out.v[i] = out.turn[i] = 0, out.z[i] = -1;
}

/// How a point of the contour moves in the image as it moves by its normal at a depth of 1.
Eigen::Vector2f Outwards(const ContourView& contour, const Projection& p, const Projected& points,
                         int i) {
  const Eigen::Vector3f normal(contour.nx[i], contour.ny[i], contour.nz[i]);
  const auto rotated = [&](int row) {
    return Eigen::Vector3f(p.r[row][0], p.r[row][1], p.r[row][2]).dot(normal);
  };
  const float along_ray = rotated(2);
  return {p.fx * rotated(0) - along_ray * (points.u[i] - p.cx),
          p.fy * rotated(1) - along_ray * (points.v[i] - p.cy)};
}

/// Which of ScoringView::outline_offsets_px is of an outline that faces there.
std::size_t SideOf(const Eigen::Vector2f& across) {
  const bool sideways = std::abs(across.x()) > std::abs(across.y());
  return sideways ? (across.x() > 0 ? 0 : 2) : (across.y() > 0 ? 1 : 3);
}

/// Moves the outline outwards in the image, each side of it by its own offset.
void Widen(const ContourView& contour, const Projection& p, const std::array<double, 4>& offsets_px,
           Projected& points) {
  for (int i = 0; i < contour.outline_size; ++i) {
    const Eigen::Vector2f across = Outwards(contour, p, points, i);
    const float length = across.norm();
    if (length <= 0) continue;
    const float offset_px = static_cast<float>(offsets_px[SideOf(across)]);
    points.u[i] += offset_px / length * across.x();
    points.v[i] += offset_px / length * across.y();
  }
}

struct Bounds {
  float x0 = std::numeric_limits<float>::max(), y0 = x0, x1 = -x0, y1 = -x0;
  Box2 Clipped(const PinholeCamera& camera) const {
    if (x1 < x0) return {};
    return Intersection({x0, y0, x1, y1}, {0, 0, static_cast<float>(camera.width - 1),
                                           static_cast<float>(camera.height - 1)});
  }
};

/// Box of the points of at least that depth and, of those, of the points that have a cell.
struct Boxes {
  Bounds whole, seen;
};

/// Finds each point's cell of the table.
PLUMBLINE_VECTORISED
void FindCells(float near_m, int width, int height, Projected& points) {
  const float right = static_cast<float>(width), bottom = static_cast<float>(height);
  const int end = points.lanes_end;  // A copy, which no cell that is written may change.
  for (int i = 0; i < end; ++i) {
    // Pixel centres are at integers: pixel 0 spans [-0.5, 0.5).
    const float u = points.u[i] + 0.5f, v = points.v[i] + 0.5f;
    const bool inside = (points.z[i] >= near_m) & (u >= 0) & (v >= 0) & (u < right) & (v < bottom);
    const int x = static_cast<int>(inside ? u : 0.0f), y = static_cast<int>(inside ? v : 0.0f);
    const int bin =
        static_cast<int>(points.turn[i] * OrientedTable::kBins) & (OrientedTable::kBins - 1);
    points.cell[i] = inside ? (bin * height + y) * width + x : -1;
  }
}

/// What of an image that is smaller than the camera's belongs to a pixel of it.
struct SmallerImage {
  float scale_x, scale_y;
  int last_x, last_y, stride;
};

/// Finds the pixel of the smaller image at each point that has a cell; that of the others is 0.
PLUMBLINE_VECTORISED
void FindPixels(const SmallerImage& image, Projected& points) {
  const SmallerImage at = image;
  const int end = points.lanes_end;
  for (int i = 0; i < end; ++i) {
    const bool inside = points.cell[i] >= 0;
    const float u = (points.u[i] + 0.5f) * at.scale_x, v = (points.v[i] + 0.5f) * at.scale_y;
    const int x = static_cast<int>(inside ? u : 0.0f), y = static_cast<int>(inside ? v : 0.0f);
    points.before[i] =
        (y < at.last_y ? y : at.last_y) * at.stride + (x < at.last_x ? x : at.last_x);
  }
}

/// Points that something in front hides lose their cell.
void Hide(const cv::Mat& occluder, float margin_m, int width, int height, Projected& points) {
  FindPixels({static_cast<float>(occluder.cols) / static_cast<float>(width),
              static_cast<float>(occluder.rows) / static_cast<float>(height), occluder.cols - 1,
              occluder.rows - 1, static_cast<int>(occluder.step1())},
             points);
  const float* depth = occluder.ptr<float>();
  for (int i = 0; i < points.lanes_end; ++i) {
    const float in_front = depth[points.before[i]];
    const bool hidden = (in_front > 0) & (in_front < points.z[i] - margin_m);
    points.cell[i] = hidden ? -1 : points.cell[i];
  }
}

PLUMBLINE_VECTORISED
Boxes FindBoxes(float near_m, const Projected& points) {
  constexpr float kNone = std::numeric_limits<float>::max();
  alignas(32) float bounds[8][kLanes];
  for (int k = 0; k < kLanes; ++k) {
    for (int b = 0; b < 8; ++b) bounds[b][k] = b % 4 < 2 ? kNone : -kNone;
  }
  for (int i = 0; i < points.lanes_end; i += kLanes) {
    for (int k = 0; k < kLanes; ++k) {
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
  const auto least = [&](int b) { return *std::min_element(bounds[b], bounds[b] + kLanes); };
  const auto most = [&](int b) { return *std::max_element(bounds[b], bounds[b] + kLanes); };
  return {{least(0), least(1), most(2), most(3)}, {least(4), least(5), most(6), most(7)}};
}

/// What a seen point of the outline gains where the edge runs along its rim [of 255].
int RimGain(const OrientedTable& table, const ContourView& contour, const Projection& p,
            const Projected& points, int i) {
  if (contour.rim[i] <= 0) return 0;
  const Eigen::Vector2f inwards = -contour.rim[i] / points.z[i] * Outwards(contour, p, points, i);
  const float weight = RimWeight(inwards.norm());
  const int x = static_cast<int>(std::floor(points.u[i] + inwards.x() + 0.5f)),
            y = static_cast<int>(std::floor(points.v[i] + inwards.y() + 0.5f));
  if (weight <= 0 || x < 0 || y < 0 || x >= table.width() || y >= table.height()) return 0;
  const int bin =
      static_cast<int>(points.turn[i] * OrientedTable::kBins) & (OrientedTable::kBins - 1);
  const int there = table.cells()[(bin * table.height() + y) * table.width() + x];
  return std::max(0, static_cast<int>(std::lround(weight * static_cast<float>(there))) -
                         table.cells()[points.cell[i]]);
}

/// What points of a contour find in the table.
struct Tally {
  std::int64_t hits = 0;  ///< [of 255]
  int seen = 0;           ///< Points of the outline,
  int looked_up = 0;      ///< and with those of inner lines.

  void Add(const Tally& other, int sign) {
    hits += sign * other.hits;
    seen += sign * other.seen;
    looked_up += sign * other.looked_up;
  }
};

/// Of points in a row, without a branch; `seen` stays 0.
Tally TallyOf(const OrientedTable& table, const Projected& points, int begin, int end) {
  const std::uint8_t* cells = table.cells();
  int hits = 0, looked_up = 0;
  for (int i = begin; i < end; ++i) {
    const int cell = points.cell[i], seen = cell >= 0 ? -1 : 0;
    hits += cells[cell & seen] & seen;
    looked_up -= seen;
  }
  return {hits, 0, looked_up};
}

/// Finds the cells of the points that are seen.
void LookFor(const ScoringView& view, Projected& points) {
  const OrientedTable& table = *view.table;
  FindCells(static_cast<float>(view.near_m), table.width(), table.height(), points);
  if (!view.occluder_depth.empty()) {
    Hide(view.occluder_depth, static_cast<float>(view.occlusion_margin_m), table.width(),
         table.height(), points);
  }
}

HypothesisScore ScoreOf(const Tally& tally, const ContourView& contour,
                        const OrientedTable& table) {
  HypothesisScore score;
  score.agreement_m =
      contour.length_per_point_m * static_cast<float>(static_cast<double>(tally.hits) / 255.0 -
                                                      tally.looked_up * table.chance());
  score.visible_m = contour.length_per_point_m * static_cast<float>(tally.seen);
  score.total_m = contour.length_per_point_m * static_cast<float>(contour.outline_size);
  return score;
}

HypothesisScore ScoreProjected(const ScoringView& view, const ContourView& contour,
                               const Projection& p, Projected& points) {
  LookFor(view, points);
  Tally tally = TallyOf(*view.table, points, 0, contour.outline_size);
  tally.seen = tally.looked_up;
  if (view.inner_lines)
    tally.Add(TallyOf(*view.table, points, contour.outline_size, contour.size), 1);
  for (int i = 0; view.rims && i < contour.outline_size; ++i)
    if (points.cell[i] >= 0) tally.hits += RimGain(*view.table, contour, p, points, i);
  const Boxes boxes = FindBoxes(static_cast<float>(view.near_m), points);
  HypothesisScore score = ScoreOf(tally, contour, *view.table);
  score.whole_box = boxes.whole.Clipped(view.camera);
  score.visible_box = boxes.seen.Clipped(view.camera);
  return score;
}

/// Of each side of the outline by itself.
using SideTallies = std::array<Tally, 4>;

SideTallies TallyOutline(const ScoringView& view, const ContourView& contour, const Projection& p,
                         const Projected& points, std::span<const std::uint8_t> sides) {
  SideTallies tallies;
  for (int i = 0; i < contour.outline_size; ++i) {
    if (points.cell[i] < 0) continue;
    Tally& tally = tallies[sides[static_cast<std::size_t>(i)]];
    tally.hits += view.table->cells()[points.cell[i]];
    if (view.rims) tally.hits += RimGain(*view.table, contour, p, points, i);
    ++tally.looked_up;
    ++tally.seen;
  }
  return tallies;
}

Tally TallyInnerLines(const ScoringView& view, const ContourView& contour,
                      const Projected& points) {
  if (!view.inner_lines) return {};
  return TallyOf(*view.table, points, contour.outline_size, contour.size);
}

}  // namespace

ViewpointScorer::ViewpointScorer(std::vector<std::shared_ptr<const ViewpointModel>> models,
                                 std::shared_ptr<const ModelDatabase> database)
    : models_(std::move(models)), database_(std::move(database)) {
  PLB_CHECK(models_.size() == database_->models().size()) << "one viewpoint model for each model";
}

template <typename ScoreOne>
void ViewpointScorer::ForEach(const ScoringView& view, const UprightFrame& upright,
                              std::span<const PoseHypothesis> hypotheses,
                              const ScoreOne& score_one) const {
  PLB_CHECK(view.table != nullptr && view.table->width() == view.camera.width &&
            view.table->height() == view.camera.height);
  const Eigen::Vector3d camera_in_world = view.cam_from_world.inverse().translation();
  const auto score_range = [&](std::size_t begin, std::size_t end) {
    static thread_local Projected projected;
    for (std::size_t i = begin; i < end; ++i) {
      const PoseHypothesis& hypothesis = hypotheses[i];
      const auto& model = models_[static_cast<std::size_t>(hypothesis.label.value)];
      const Eigen::Vector3d center = database_->model(hypothesis.label).center();
      const double scale = hypothesis.scale();
      const Eigen::Matrix3d world_from_object =
          upright.WorldFromObjectRotation(hypothesis.azimuth_rad);
      const Eigen::Vector3d camera_in_object =
          world_from_object.transpose() * (camera_in_world - hypothesis.center_in_world) / scale +
          center;
      ContourView contour = model->View(camera_in_object.cast<float>());
      contour.length_per_point_m *= static_cast<float>(scale);
      PLB_CHECK(contour.size <= kMaxPoints);
      const Eigen::Matrix3d linear = scale * (view.cam_from_world.linear() * world_from_object);
      const Eigen::Vector3d translation =
          view.cam_from_world * hypothesis.center_in_world - linear * center;
      Projection p;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) p.r[r][c] = static_cast<float>(linear(r, c));
        p.t[r] = static_cast<float>(translation[r]);
      }
      p.fx = static_cast<float>(view.camera.fx);
      p.fy = static_cast<float>(view.camera.fy);
      p.cx = static_cast<float>(view.camera.cx);
      p.cy = static_cast<float>(view.camera.cy);
      Project(contour, p, projected);
      score_one(i, contour, p, projected);
    }
  };
  if (hypotheses.size() < 64) {
    score_range(0, hypotheses.size());
  } else {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, hypotheses.size(), 32),
                      [&](const auto& range) { score_range(range.begin(), range.end()); });
  }
}

void ViewpointScorer::Score(const ScoringView& view, const UprightFrame& upright,
                            std::span<const PoseHypothesis> hypotheses,
                            std::span<HypothesisScore> scores) const {
  PLB_CHECK(scores.size() == hypotheses.size());
  ForEach(view, upright, hypotheses,
          [&](std::size_t i, const ContourView& contour, const Projection& p, Projected& points) {
            if (view.outline_offsets_px != std::array<double, 4>{})
              Widen(contour, p, view.outline_offsets_px, points);
            scores[i] = ScoreProjected(view, contour, p, points);
          });
}

SideScores ViewpointScorer::ScoreSides(const ScoringView& view, const UprightFrame& upright,
                                       std::span<const PoseHypothesis> hypotheses,
                                       double offset_px) const {
  SideScores scores;
  scores.fill(std::vector<HypothesisScore>(hypotheses.size()));
  ForEach(view, upright, hypotheses,
          [&](std::size_t i, const ContourView& contour, const Projection& p, Projected& points) {
            static thread_local Projected moved;
            std::array<std::uint8_t, kMaxPoints> sides;
            for (int k = 0; k < contour.outline_size; ++k)
              sides[static_cast<std::size_t>(k)] =
                  static_cast<std::uint8_t>(SideOf(Outwards(contour, p, points, k)));
            std::array<SideTallies, 2> beside;
            for (const std::size_t inwards : {0, 1}) {
              moved = points;
              const double by_px = inwards == 0 ? offset_px : -offset_px;
              Widen(contour, p, {by_px, by_px, by_px, by_px}, moved);
              LookFor(view, moved);
              beside[inwards] = TallyOutline(view, contour, p, moved, sides);
            }
            LookFor(view, points);
            const SideTallies there = TallyOutline(view, contour, p, points, sides);
            Tally all = TallyInnerLines(view, contour, points);
            for (const Tally& side : there) all.Add(side, 1);
            for (std::size_t k = 0; k < scores.size(); ++k) {
              Tally tally = all;
              tally.Add(there[k % 4], -1);
              tally.Add(beside[k / 4][k % 4], 1);
              scores[k][i] = ScoreOf(tally, contour, *view.table);
            }
          });
  return scores;
}

std::vector<ContourPointFound> ViewpointScorer::PointsFound(
    const ScoringView& view, const UprightFrame& upright, const PoseHypothesis& hypothesis) const {
  std::vector<ContourPointFound> found;
  ForEach(view, upright, {&hypothesis, 1},
          [&](std::size_t, const ContourView& contour, const Projection& p, Projected& points) {
            ScoringView open = view;
            open.occluder_depth.release();
            LookFor(open, points);
            std::vector<int> inside;
            for (int i = 0; i < contour.size; ++i) {
              if (points.cell[i] < 0) continue;
              inside.push_back(i);
              int hit = view.table->cells()[points.cell[i]];
              if (view.rims && i < contour.outline_size)
                hit += RimGain(*view.table, contour, p, points, i);
              found.push_back({{points.u[i], points.v[i]},
                               Outwards(contour, p, points, i).normalized(),
                               false,
                               static_cast<float>(hit) / 255.0f});
            }
            LookFor(view, points);
            for (std::size_t k = 0; k < found.size(); ++k)
              found[k].seen = points.cell[inside[k]] >= 0;
          });
  return found;
}

}  // namespace plumbline
