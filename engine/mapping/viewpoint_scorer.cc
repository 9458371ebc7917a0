// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/viewpoint_scorer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/check.h"

namespace plumbline {
namespace {

constexpr int kMaxPoints = 1024;

/// The projection of one contour.
struct Projected {
  alignas(64) float u[kMaxPoints];
  alignas(64) float v[kMaxPoints];
  alignas(64) float z[kMaxPoints];
  alignas(
      64) float turn[kMaxPoints];  ///< Direction of the normal in the image, in half turns [0, 1].
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

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
__attribute__((target_clones("arch=x86-64-v3", "default")))
#endif
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
}

struct Bounds {
  float x0 = std::numeric_limits<float>::max(), y0 = x0, x1 = -x0, y1 = -x0;
  void Extend(float x, float y) {
    x0 = x < x0 ? x : x0;
    y0 = y < y0 ? y : y0;
    x1 = x > x1 ? x : x1;
    y1 = y > y1 ? y : y1;
  }
  Box2 Clipped(const PinholeCamera& camera) const {
    if (x1 < x0) return {};
    return Intersection({x0, y0, x1, y1}, {0, 0, static_cast<float>(camera.width - 1),
                                           static_cast<float>(camera.height - 1)});
  }
};

HypothesisScore ScoreProjected(const ScoringView& view, const ContourView& contour,
                               const Projected& points) {
  const OrientedTable& table = *view.table;
  const float near_m = static_cast<float>(view.near_m);
  const float margin = static_cast<float>(view.occlusion_margin_m);
  const float width = static_cast<float>(table.width()),
              height = static_cast<float>(table.height());
  const cv::Mat& occluder = view.occluder_depth;
  const bool may_hide = !occluder.empty();
  const float scale_x = may_hide ? occluder.cols / width : 0,
              scale_y = may_hide ? occluder.rows / height : 0;
  Bounds whole, visible;
  std::int64_t hits = 0;
  int seen = 0, looked_up = 0;
  for (int i = 0; i < contour.size; ++i) {
    if (points.z[i] < near_m) continue;
    // Pixel centres are at integers: pixel 0 spans [-0.5, 0.5).
    const float u = points.u[i] + 0.5f, v = points.v[i] + 0.5f;
    whole.Extend(points.u[i], points.v[i]);
    if (!(u >= 0 && v >= 0 && u < width && v < height)) continue;
    if (may_hide) {
      const float in_front =
          occluder.ptr<float>(static_cast<int>(v * scale_y))[static_cast<int>(u * scale_x)];
      if (in_front > 0 && in_front < points.z[i] - margin) continue;
    }
    visible.Extend(points.u[i], points.v[i]);
    ++looked_up;
    seen += i < contour.outline_size ? 1 : 0;
    const int bin =
        static_cast<int>(points.turn[i] * OrientedTable::kBins) & (OrientedTable::kBins - 1);
    hits += table.Hit(static_cast<int>(u), static_cast<int>(v), bin);
  }
  HypothesisScore score;
  score.agreement_m =
      contour.length_per_point_m *
      static_cast<float>(static_cast<double>(hits) / 255.0 - looked_up * table.chance());
  score.visible_m = contour.length_per_point_m * static_cast<float>(seen);
  score.total_m = contour.length_per_point_m * static_cast<float>(contour.outline_size);
  score.whole_box = whole.Clipped(view.camera);
  score.visible_box = visible.Clipped(view.camera);
  return score;
}

}  // namespace

ViewpointScorer::ViewpointScorer(std::vector<std::shared_ptr<const ViewpointModel>> models,
                                 std::shared_ptr<const ModelDatabase> database)
    : models_(std::move(models)), database_(std::move(database)) {
  PLB_CHECK(models_.size() == database_->models().size()) << "one viewpoint model for each model";
}

void ViewpointScorer::Score(const ScoringView& view, const UprightFrame& upright,
                            std::span<const PoseHypothesis> hypotheses,
                            std::span<HypothesisScore> scores) const {
  PLB_CHECK(scores.size() == hypotheses.size());
  PLB_CHECK(view.table != nullptr && view.table->width() == view.camera.width &&
            view.table->height() == view.camera.height);
  const Eigen::Vector3d camera_in_world = view.cam_from_world.inverse().translation();
  const auto score_range = [&](std::size_t begin, std::size_t end) {
    static thread_local Projected projected;
    for (std::size_t i = begin; i < end; ++i) {
      const PoseHypothesis& hypothesis = hypotheses[i];
      const auto& model = models_[static_cast<std::size_t>(hypothesis.label.value)];
      const Eigen::Vector3d center = database_->model(hypothesis.label).center();
      const Eigen::Matrix3d world_from_object =
          upright.WorldFromObjectRotation(hypothesis.azimuth_rad);
      const Eigen::Vector3d camera_in_object =
          world_from_object.transpose() * (camera_in_world - hypothesis.center_in_world) + center;
      const ContourView contour = model->View(camera_in_object.cast<float>());
      PLB_CHECK(contour.size <= kMaxPoints);
      const Eigen::Matrix3d rotation = view.cam_from_world.linear() * world_from_object;
      const Eigen::Vector3d translation =
          view.cam_from_world * hypothesis.center_in_world - rotation * center;
      Projection p;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) p.r[r][c] = static_cast<float>(rotation(r, c));
        p.t[r] = static_cast<float>(translation[r]);
      }
      p.fx = static_cast<float>(view.camera.fx);
      p.fy = static_cast<float>(view.camera.fy);
      p.cx = static_cast<float>(view.camera.cx);
      p.cy = static_cast<float>(view.camera.cy);
      Project(contour, p, projected);
      scores[i] = ScoreProjected(view, contour, projected);
    }
  };
  if (hypotheses.size() < 64) {
    score_range(0, hypotheses.size());
  } else {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, hypotheses.size(), 32),
                      [&](const auto& range) { score_range(range.begin(), range.end()); });
  }
}

}  // namespace plumbline
