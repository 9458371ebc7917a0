// SPDX-License-Identifier: Apache-2.0
#include "engine/models/side_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace plumbline {
namespace {

constexpr int kLongerSide_px = 128;
constexpr float kStep_share = 0.01f, kSamePlane_share = 0.015f;  ///< Of the diagonal.
constexpr float kSlopeCosine = 0.87f;                            ///< 30 degrees.
constexpr float kColorStep = 0.08f;

struct Seen {
  float depth = std::numeric_limits<float>::lowest();  ///< Toward the eye.
  Eigen::Vector3f normal{0, 0, 0};
  float grey = 0;
  bool hit() const { return depth > std::numeric_limits<float>::lowest(); }
};

/// A picture without perspective.
class FarView {
 public:
  FarView(const TriangleMesh& mesh, const SignedAxis& toward_eye, const SignedAxis& up)
      : mesh_(mesh), diagonal_(BoundingBox(mesh).diagonal().norm()) {
    axes_.row(0) = up.vector().cross(toward_eye.vector()).cast<float>();
    axes_.row(1) = up.vector().cast<float>();
    axes_.row(2) = toward_eye.vector().cast<float>();
    for (const Eigen::Vector3f& vertex : mesh.vertices)
      bounds_.extend(Eigen::Vector3f(axes_ * vertex));
    const float longer = std::max({bounds_.sizes().x(), bounds_.sizes().y(), 1e-12f});
    scale_ = static_cast<float>(kLongerSide_px - 1) / longer;
    width_ = static_cast<int>(bounds_.sizes().x() * scale_) + 1;
    height_ = static_cast<int>(bounds_.sizes().y() * scale_) + 1;
    seen_.resize(static_cast<std::size_t>(width_ * height_));
    for (const Eigen::Vector3i& triangle : mesh.triangles) Draw(triangle);
  }

  SideView Summary() const {
    int hits = 0, shape = 0, color = 0;
    std::vector<float> facing;
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const Seen& here = At(x, y);
        if (!here.hit()) continue;
        ++hits;
        if (std::abs(here.normal.z()) > 0.97f) facing.push_back(here.depth);
        bool bends = false, changes = false;
        for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
          if (x + dx >= width_ || y + dy >= height_ || !At(x + dx, y + dy).hit()) continue;
          const Seen& next = At(x + dx, y + dy);
          const bool one = std::abs(next.depth - here.depth) < kStep_share * diagonal_ &&
                           std::abs(next.normal.dot(here.normal)) > kSlopeCosine;
          bends = bends || !one;
          changes = changes || (one && std::abs(next.grey - here.grey) > kColorStep);
        }
        shape += bends;
        color += changes;
      }
    }
    if (hits == 0) return {};
    return {static_cast<double>(shape) / hits, static_cast<double>(color) / hits,
            static_cast<double>(InOnePlane(std::move(facing))) / hits};
  }

 private:
  const Seen& At(int x, int y) const { return seen_[static_cast<std::size_t>(y * width_ + x)]; }

  void Draw(const Eigen::Vector3i& t) {
    std::array<Eigen::Vector3f, 3> p;
    std::array<float, 3> grey{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto vertex = static_cast<std::size_t>(t[static_cast<int>(c)]);
      p[c] = axes_ * mesh_.vertices[vertex] - bounds_.min();
      p[c].head<2>() *= scale_;
      if (mesh_.colors.empty()) continue;
      grey[c] = Luminance(mesh_.colors[vertex]);
    }
    const Eigen::Vector2f ab = (p[1] - p[0]).head<2>(), ac = (p[2] - p[0]).head<2>();
    const float area = ab.x() * ac.y() - ab.y() * ac.x();
    if (std::abs(area) < 1e-9f) return;
    Eigen::Vector3f normal = Unscaled(p[1] - p[0]).cross(Unscaled(p[2] - p[0])).normalized();
    if (normal.z() < 0) normal = -normal;
    const auto low = [&](int i) { return std::min({p[0][i], p[1][i], p[2][i]}); };
    const auto high = [&](int i) { return std::max({p[0][i], p[1][i], p[2][i]}); };
    for (int y = static_cast<int>(std::ceil(low(1))); y <= high(1) && y < height_; ++y) {
      for (int x = static_cast<int>(std::ceil(low(0))); x <= high(0) && x < width_; ++x) {
        const Eigen::Vector2f to = Eigen::Vector2f(x, y) - p[0].head<2>();
        const float b = (to.x() * ac.y() - to.y() * ac.x()) / area;
        const float c = (ab.x() * to.y() - ab.y() * to.x()) / area;
        if (b < 0 || c < 0 || b + c > 1) continue;
        const float depth = (1 - b - c) * p[0].z() + b * p[1].z() + c * p[2].z();
        Seen& seen = seen_[static_cast<std::size_t>(y * width_ + x)];
        if (depth <= seen.depth) continue;
        seen = {depth, normal, (1 - b - c) * grey[0] + b * grey[1] + c * grey[2]};
      }
    }
  }

  Eigen::Vector3f Unscaled(Eigen::Vector3f v) const {
    v.head<2>() /= scale_;
    return v;
  }

  /// The most depths that are all within a plane's thickness.
  int InOnePlane(std::vector<float> depths) const {
    std::sort(depths.begin(), depths.end());
    std::size_t most = 0;
    for (std::size_t first = 0, last = 0; last < depths.size(); ++last) {
      while (depths[last] - depths[first] > kSamePlane_share * diagonal_) ++first;
      most = std::max(most, last - first + 1);
    }
    return static_cast<int>(most);
  }

  const TriangleMesh& mesh_;
  float diagonal_, scale_ = 1;
  Eigen::Matrix3f axes_;
  Eigen::AlignedBox3f bounds_;
  int width_ = 0, height_ = 0;
  std::vector<Seen> seen_;
};

}  // namespace

SideView LookFrom(const TriangleMesh& mesh, const SignedAxis& toward_eye, const SignedAxis& up) {
  return FarView(mesh, toward_eye, up).Summary();
}

}  // namespace plumbline
