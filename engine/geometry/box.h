// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace plumbline {

/// An image box [px]: corners in pixel-centre coordinates, x0 <= x1 and y0 <= y1 unless empty.
struct Box2 {
  float x0 = 0, y0 = 0, x1 = -1, y1 = -1;

  bool empty() const { return !(x1 > x0 && y1 > y0); }
  float width() const { return x1 - x0; }
  float height() const { return y1 - y0; }
  float area() const { return empty() ? 0.0f : width() * height(); }
  float center_x() const { return 0.5f * (x0 + x1); }
  float center_y() const { return 0.5f * (y0 + y1); }
  bool operator==(const Box2&) const = default;
};

inline Box2 Intersection(const Box2& a, const Box2& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

/// The smallest box that holds both.
inline Box2 Union(const Box2& a, const Box2& b) {
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

/// Intersection over union; 0 if either box is empty.
inline float Iou(const Box2& a, const Box2& b) {
  const float shared = Intersection(a, b).area();
  const float together = a.area() + b.area() - shared;
  return together > 0 ? shared / together : 0.0f;
}

}  // namespace plumbline
