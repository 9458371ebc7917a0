// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
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

constexpr int kAtOnce = 8;

/// Of the next kAtOnce pixels.
bool NoneMarked(const std::uint8_t* marks) {
  std::uint64_t eight = 0;
  std::memcpy(&eight, marks, kAtOnce);
  return eight == 0;
}

/// The pixels of a row from its second on, and the four neighbours of each: five pointers, since
/// loops that take one at three places do not vectorise.
template <typename T>
struct Neighbours {
  const T *at, *left, *right, *above, *below;
  Neighbours(const cv::Mat& map, int y)
      : at(map.ptr<T>(y) + 1),
        left(at - 1),
        right(at + 1),
        above(map.ptr<T>(y - 1) + 1),
        below(map.ptr<T>(y + 1) + 1) {}
};

/// Marks what may be on the contour: pixels of a surface that have a neighbour of another id, or
/// one that lies more than `step_m` behind.
PLUMBLINE_VECTORISED
void MarkSteps(const Neighbours<float>& depth, const Neighbours<std::uint16_t>& id, int count,
               float step_m, std::uint8_t* __restrict marks) {
  const Neighbours<float> d = depth;
  const Neighbours<std::uint16_t> i = id;
  for (int x = 0; x < count; ++x) {
    const std::uint16_t here = i.at[x];
    const int other =
        (i.left[x] ^ here) | (i.right[x] ^ here) | (i.above[x] ^ here) | (i.below[x] ^ here);
    marks[x] = other != 0 ? 1 : 0;
  }
  for (int x = 0; x < count; ++x) {
    const float here = d.at[x], across = d.left[x] > d.right[x] ? d.left[x] : d.right[x],
                along = d.above[x] > d.below[x] ? d.above[x] : d.below[x];
    const float farthest = across > along ? across : along;
    const int step = farthest - here > step_m ? 1 : 0, surface = here != 0.0f ? 1 : 0;
    marks[x] = static_cast<std::uint8_t>((step | marks[x]) & surface);
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
  // Eight zeros after the last, so that the search for marks may read beyond it.
  std::vector<std::uint8_t> marks(static_cast<std::size_t>(depth.cols) + kAtOnce);
  for (int y = 1; y < depth.rows - 1; ++y) {
    MarkSteps({depth, y}, {id, y}, depth.cols - 2, static_cast<float>(contour_step_m),
              marks.data());
    auto* row = contour.ptr<std::uint8_t>(y);
    for (int x = 1; x < depth.cols - 1; x += kAtOnce) {
      if (NoneMarked(marks.data() + x - 1)) continue;
      for (int k = x; k < x + kAtOnce; ++k) {
        if (marks[static_cast<std::size_t>(k - 1)] != 0 && rule.OnContour({k, y})) row[k] = 255;
      }
    }
  }
  return contour;
}

}  // namespace plumbline
