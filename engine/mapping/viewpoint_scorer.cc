// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/viewpoint_scorer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "engine/base/check.h"
#include "engine/mapping/projected_contour.h"

namespace plumbline {
namespace {

HypothesisScore ScoreOf(const ContourTally& outline, const ContourTally& inner_lines,
                        const ContourView& contour, const OrientedTable& table) {
  const double hits = static_cast<double>(outline.hits + inner_lines.hits) / 255.0;
  HypothesisScore score;
  score.agreement_m = contour.length_per_point_m *
                      static_cast<float>(hits - (outline.seen + inner_lines.seen) * table.chance());
  score.visible_m = contour.length_per_point_m * static_cast<float>(outline.seen);
  score.total_m = contour.length_per_point_m * static_cast<float>(contour.outline_size);
  return score;
}

/// Of points whose hits have been found.
HypothesisScore ScoreFound(const ScoringView& view, const ContourView& contour,
                           ProjectedContour& points) {
  LeaveOutUncontrasted(view, contour, points);
  return ScoreOf(TallyOutline(points), view.inner_lines ? TallyInnerLines(points) : ContourTally{},
                 contour, *view.table);
}

HypothesisScore ScoreProjected(const ScoringView& view, const ContourView& contour,
                               const ContourProjection& p, ProjectedContour& points) {
  FindHits(view, contour, p, points);
  // A detector sees what has no contrast, too.
  const ContourBoxes boxes = FindBoxes(view.near_m, points);
  HypothesisScore score = ScoreFound(view, contour, points);
  score.whole_box = boxes.whole.Clipped(view.camera);
  score.visible_box = boxes.seen.Clipped(view.camera);
  return score;
}

/// Of the outline with one side in place of another.
ContourTally Replaced(ContourTally all, const ContourTally& side, const ContourTally& by) {
  return {all.hits - side.hits + by.hits, all.seen - side.seen + by.seen};
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
    static thread_local ProjectedContour projected;
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
      PLB_CHECK(contour.size <= ProjectedContour::kMaxPoints);
      const Eigen::Matrix3d linear = scale * (view.cam_from_world.linear() * world_from_object);
      const Eigen::Vector3d translation =
          view.cam_from_world * hypothesis.center_in_world - linear * center;
      ContourProjection p;
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
          [&](std::size_t i, const ContourView& contour, const ContourProjection& p,
              ProjectedContour& points) {
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
          [&](std::size_t i, const ContourView& contour, const ContourProjection& p,
              ProjectedContour& points) {
            static thread_local ProjectedContour moved;
            std::array<std::array<ContourTally, 4>, 2> beside;
            for (const std::size_t inwards : {0, 1}) {
              CopyPoints(points, moved);
              const double by_px = inwards == 0 ? offset_px : -offset_px;
              Widen(contour, p, {by_px, by_px, by_px, by_px}, moved);
              FindHits(view, contour, p, moved);
              LeaveOutUncontrasted(view, contour, moved);
              beside[inwards] = TallySides(moved);
            }
            FindSides(contour, p, points);
            FindHits(view, contour, p, points);
            LeaveOutUncontrasted(view, contour, points);
            const ContourTally all = TallyOutline(points);
            const ContourTally inner_lines =
                view.inner_lines ? TallyInnerLines(points) : ContourTally{};
            const std::array<ContourTally, 4> there = TallySides(points);
            for (std::size_t k = 0; k < scores.size(); ++k) {
              scores[k][i] = ScoreOf(Replaced(all, there[k % 4], beside[k / 4][k % 4]), inner_lines,
                                     contour, *view.table);
            }
          });
  return scores;
}

std::vector<HypothesisScore> ViewpointScorer::ScoreShifts(
    const ScoringView& view, const UprightFrame& upright,
    std::span<const PoseHypothesis> hypotheses, std::span<const ImageShift> shifts) const {
  std::vector<HypothesisScore> scores(shifts.size() * hypotheses.size());
  ForEach(view, upright, hypotheses,
          [&](std::size_t i, const ContourView& contour, const ContourProjection& p,
              ProjectedContour& points) {
            if (view.outline_offsets_px != std::array<double, 4>{})
              Widen(contour, p, view.outline_offsets_px, points);
            ContourProjection moved = p;
            for (std::size_t k = 0; k < shifts.size(); ++k) {
              const float cx = p.cx + static_cast<float>(shifts[k].x_px),
                          cy = p.cy + static_cast<float>(shifts[k].y_px);
              Move(cx - moved.cx, cy - moved.cy, points);
              moved.cx = cx;
              moved.cy = cy;
              FindHits(view, contour, moved, points);
              scores[k * hypotheses.size() + i] = ScoreFound(view, contour, points);
            }
          });
  return scores;
}

std::vector<ContourPointFound> ViewpointScorer::PointsFound(
    const ScoringView& view, const UprightFrame& upright, const PoseHypothesis& hypothesis) const {
  std::vector<ContourPointFound> found;
  ForEach(
      view, upright, {&hypothesis, 1},
      [&](std::size_t, const ContourView& contour, const ContourProjection& p,
          ProjectedContour& points) {
        ScoringView open = view;
        open.occluder_depth.release();
        FindHits(open, contour, p, points);
        FindNormals(contour, p, points);
        std::vector<int> inside;
        for (int i = 0; i < contour.size; ++i) {
          if (points.cell[i] < 0) continue;
          inside.push_back(i);
          found.push_back({{points.u[i], points.v[i]},
                           Eigen::Vector2f(points.outwards_u[i], points.outwards_v[i]).normalized(),
                           false,
                           static_cast<float>(points.hit[i]) / 255.0f});
        }
        FindHits(view, contour, p, points);
        LeaveOutUncontrasted(view, contour, points);
        for (std::size_t k = 0; k < found.size(); ++k) found[k].seen = points.cell[inside[k]] >= 0;
      });
  return found;
}

}  // namespace plumbline
