// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <vector>

#include "engine/base/check.h"
#include "engine/base/vectorised.h"
#include "engine/render/renderer.h"

// A pixel is on the contour if one of its four neighbours lies behind it across a silhouette
// (background or another object) or across a step of its own surface. A step counts only beyond
// what the slope on either side explains: the surface continued as a plane from the near side, or
// from the far side, reaches part of the way. The far side matters at creases, where a face seen
// squarely meets one seen at a grazing angle. shaders/likelihood/contour.frag does the same.
namespace plumbline {
namespace {

/// Marks what may be on the contour of a row: pixels of a surface that have a neighbour of another
/// id, or one that lies more than `step_m` behind. Rows are read from one before to one after.
PLUMBLINE_VECTORISED
void MarkSteps(const std::array<const float*, 3>& depth_rows,
               const std::array<const std::uint16_t*, 3>& id_rows, int count, float step_m,
               std::uint8_t* __restrict marks) {
  const float *above = depth_rows[0], *at = depth_rows[1], *below = depth_rows[2];
  const std::uint16_t *id_above = id_rows[0], *ids = id_rows[1], *id_below = id_rows[2];
  for (int x = 0; x < count; ++x) {
    const float far = std::max(std::max(at[x - 1], at[x + 1]), std::max(above[x], below[x]));
    const int other = (ids[x - 1] ^ ids[x]) | (ids[x + 1] ^ ids[x]) | (id_above[x] ^ ids[x]) |
                      (id_below[x] ^ ids[x]);
    const bool surface = at[x] != 0.0f, step = far - at[x] > step_m, border = other != 0;
    marks[x] = surface && (step || border) ? 1 : 0;
  }
}

class ContourRule {
 public:
  ContourRule(const cv::Mat& depth, const cv::Mat& id, float step_m)
      : depth_(depth), id_(id), step_m_(step_m) {}

  bool OnContour(cv::Point p) const {
    return Depth(p) != 0.0f && (NearSide(p, {1, 0}) || NearSide(p, {-1, 0}) ||
                                NearSide(p, {0, 1}) || NearSide(p, {0, -1}));
  }

 private:
  float Depth(cv::Point p) const { return depth_.at<float>(p); }
  std::uint16_t Id(cv::Point p) const { return id_.at<std::uint16_t>(p); }
  bool Inside(cv::Point p) const {
    return p.x >= 0 && p.y >= 0 && p.x < depth_.cols && p.y < depth_.rows;
  }

  /// Depth one pixel beyond `at`, coming from `before`: planes are linear in inverse depth.
  static float Continued(float before, float at) {
    const float inverse = 2.0f / at - 1.0f / before;
    return inverse > 0.0f ? 1.0f / inverse : at;
  }

  bool NearSide(cv::Point p, cv::Point step_px) const {
    const cv::Point q = p + step_px, before = p - step_px, beyond = q + step_px;
    const float near_depth = Depth(p), far_depth = Depth(q);
    if (far_depth == 0.0f) return true;
    const std::uint16_t id = Id(p), other = Id(q);
    if (id != other) return near_depth < far_depth || (near_depth == far_depth && id < other);
    if (far_depth - near_depth <= step_m_) return false;
    float explained = 0.0f;
    if (Inside(before) && Id(before) == id) {
      explained = std::max(explained, Continued(Depth(before), near_depth) - near_depth);
    }
    if (Inside(beyond) && Id(beyond) == id) {
      explained = std::max(explained, far_depth - Continued(Depth(beyond), far_depth));
    }
    return far_depth - near_depth > step_m_ + explained;
  }

  const cv::Mat& depth_;
  const cv::Mat& id_;
  float step_m_;
};

}  // namespace

cv::Mat ContourOf(const cv::Mat& depth, const cv::Mat& id, double contour_step_m) {
  PLB_CHECK(depth.type() == CV_32F && id.type() == CV_16U && depth.size() == id.size())
      << "depth and id maps do not match";
  cv::Mat contour(depth.size(), CV_8U, cv::Scalar(0));
  const ContourRule rule(depth, id, static_cast<float>(contour_step_m));
  std::vector<std::uint8_t> marks(static_cast<std::size_t>(std::max(depth.cols, 2)));
  for (int y = 1; y < depth.rows - 1; ++y) {
    MarkSteps({depth.ptr<float>(y - 1) + 1, depth.ptr<float>(y) + 1, depth.ptr<float>(y + 1) + 1},
              {id.ptr<std::uint16_t>(y - 1) + 1, id.ptr<std::uint16_t>(y) + 1,
               id.ptr<std::uint16_t>(y + 1) + 1},
              depth.cols - 2, static_cast<float>(contour_step_m), marks.data());
    auto* row = contour.ptr<std::uint8_t>(y);
    for (int x = 1; x < depth.cols - 1; ++x) {
      if (marks[static_cast<std::size_t>(x - 1)] != 0 && rule.OnContour({x, y})) row[x] = 255;
    }
  }
  return contour;
}

}  // namespace plumbline
