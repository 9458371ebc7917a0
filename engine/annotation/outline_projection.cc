// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/outline_projection.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace plumbline {
namespace {

constexpr float kNear_m = 0.05f;
constexpr float kShortestChain_px = 2;
/// How far beyond a contour the ray passes that looks for what lies behind it, and over how much of
/// the line to either side its direction is averaged.
constexpr float kBeyond_px = 1.5f, kSmooth_px = 3;

/// An edge of the mesh that may be part of the outline.
struct Segment {
  int begin, end;
  Eigen::Vector2f normal;  ///< Unit; of a contour away from the surface.
  OutlineKind kind;
};

/// Segments that follow on one another; `normals[i]` belongs to the piece from vertex i to i + 1.
struct Chain {
  std::vector<int> vertices;
  std::vector<Eigen::Vector2f> normals;
  OutlineKind kind;
};

/// Links segments of one kind that share vertices, straight on where there is a choice.
class Linker {
 public:
  Linker(const std::vector<Segment>& segments, const std::vector<Eigen::Vector2f>& pixels)
      : segments_(segments),
        pixels_(pixels),
        used_(segments.size(), 0),
        first_(pixels.size(), -1),
        next_(2 * segments.size(), -1) {
    for (std::size_t i = segments.size(); i-- > 0;) {
      for (int k = 0; k < 2; ++k) {
        const int vertex = k == 0 ? segments[i].begin : segments[i].end;
        next_[2 * i + k] = first_[static_cast<std::size_t>(vertex)];
        first_[static_cast<std::size_t>(vertex)] = static_cast<int>(2 * i) + k;
      }
    }
  }

  std::vector<Chain> Link() {
    std::vector<Chain> chains;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      if (used_[i]) continue;
      used_[i] = 1;
      const Segment& seed = segments_[i];
      Chain back{{seed.end, seed.begin}, {seed.normal}, seed.kind};
      Extend(back);
      Chain chain{{back.vertices.rbegin(), back.vertices.rend()},
                  {back.normals.rbegin(), back.normals.rend()},
                  seed.kind};
      Extend(chain);
      chains.push_back(std::move(chain));
    }
    return chains;
  }

 private:
  Eigen::Vector2f Direction(int from, int to) const {
    return (pixels_[static_cast<std::size_t>(to)] - pixels_[static_cast<std::size_t>(from)])
        .normalized();
  }

  void Extend(Chain& chain) {
    while (true) {
      const int at = chain.vertices.back();
      const Eigen::Vector2f ahead = Direction(chain.vertices[chain.vertices.size() - 2], at);
      int best = -1;
      float best_turn = -0.5f;  // A sharper turn begins a new line.
      for (int half = first_[static_cast<std::size_t>(at)]; half >= 0;
           half = next_[static_cast<std::size_t>(half)]) {
        const std::size_t i = static_cast<std::size_t>(half / 2);
        if (used_[i] || segments_[i].kind != chain.kind) continue;
        const int other = half % 2 == 0 ? segments_[i].end : segments_[i].begin;
        const float turn = ahead.dot(Direction(at, other));
        if (turn <= best_turn) continue;
        best_turn = turn;
        best = half;
      }
      if (best < 0) return;
      const std::size_t i = static_cast<std::size_t>(best / 2);
      used_[i] = 1;
      chain.vertices.push_back(best % 2 == 0 ? segments_[i].end : segments_[i].begin);
      chain.normals.push_back(segments_[i].normal);
    }
  }

  const std::vector<Segment>& segments_;
  const std::vector<Eigen::Vector2f>& pixels_;
  std::vector<char> used_;
  std::vector<int> first_, next_;
};

class Projector {
 public:
  Projector(const OutlineModel& model, const Eigen::Isometry3d& scan_from_object,
            const Eigen::Isometry3d& scan_from_cam, const PinholeCamera& camera,
            const Occluders& occluders, const OutlineOptions& options)
      : model_(model),
        cam_from_object_((scan_from_cam.inverse() * scan_from_object).cast<float>()),
        object_from_cam_(cam_from_object_.inverse()),
        focal_(static_cast<float>(camera.fx), static_cast<float>(camera.fy)),
        principal_(static_cast<float>(camera.cx), static_cast<float>(camera.cy)),
        limit_(static_cast<float>(camera.width - 1), static_cast<float>(camera.height - 1)),
        step_px_(static_cast<float>(options.step_px)),
        step_m_(std::min(static_cast<float>(options.contour_step_m), 0.3f * model.radius())),
        others_(occluders, model, scan_from_object, scan_from_cam, options.occlusion_margin_m,
                options.own_scan_m) {}

  ModelOutline Run() {
    if ((cam_from_object_ * model_.center()).z() < -model_.radius()) return {};
    in_cam_.reserve(model_.vertices().size());
    for (const Eigen::Vector3f& vertex : model_.vertices()) {
      in_cam_.push_back(cam_from_object_ * vertex);
      pixels_.push_back(ToPixel(in_cam_.back()));
    }
    const std::vector<Segment> segments = FindSegments();
    for (const Chain& chain : Linker(segments, pixels_).Link()) Sample(chain);
    return std::move(outline_);
  }

 private:
  enum class State { kGone, kVisible, kHidden };

  Eigen::Vector2f ToPixel(const Eigen::Vector3f& in_cam) const {
    return focal_.cwiseProduct(in_cam.head<2>() / std::max(in_cam.z(), 1e-6f)) + principal_;
  }
  Eigen::Vector2f ToBearing(const Eigen::Vector2f& pixel) const {
    return (pixel - principal_).cwiseQuotient(focal_);
  }

  /// Edges that fold away from the camera or end there, and creases. Which side of the plane
  /// through edge and camera the faces lie on tells, whatever way they are wound.
  std::vector<Segment> FindSegments() const {
    std::vector<Segment> segments;
    for (const OutlineModel::Edge& edge : model_.edges()) {
      const auto at = [&](int i) -> const Eigen::Vector3f& {
        return in_cam_[static_cast<std::size_t>(i)];
      };
      const Eigen::Vector3f &a = at(edge.begin), &b = at(edge.end);
      if (a.z() < kNear_m || b.z() < kNear_m) continue;
      const Eigen::Vector3f plane = a.cross(b);
      const float side = plane.dot(at(edge.opposite));
      const bool contour = edge.opposite2 < 0 || side * plane.dot(at(edge.opposite2)) > 0;
      if (!contour && !edge.crease) continue;
      const Eigen::Vector2f &p = pixels_[static_cast<std::size_t>(edge.begin)],
                            &q = pixels_[static_cast<std::size_t>(edge.end)];
      if ((p.array() < 0 && q.array() < 0).any() ||
          (p.array() > limit_.array() && q.array() > limit_.array()).any()) {
        continue;
      }
      const Eigen::Vector2f along = q - p;
      const float length = along.norm();
      if (length < 1e-3f) continue;
      const float sign = contour && side > 0 ? -1.0f : 1.0f;
      segments.push_back({edge.begin, edge.end,
                          sign / length * Eigen::Vector2f(-along.y(), along.x()),
                          contour ? OutlineKind::kContour : OutlineKind::kCrease});
    }
    return segments;
  }

  void Sample(const Chain& chain) {
    arc_.assign(1, 0);
    for (std::size_t i = 1; i < chain.vertices.size(); ++i) {
      arc_.push_back(arc_.back() + (Pixel(chain, i) - Pixel(chain, i - 1)).norm());
    }
    const float length = arc_.back();
    if (length < kShortestChain_px) return;
    const int count = std::max(1, static_cast<int>(std::lround(length / step_px_)));
    const float step = length / static_cast<float>(count);
    State run = State::kGone;
    float run_begin = 0;
    std::size_t piece = 0;
    for (int k = 0; k < count; ++k) {
      const State state = SampleAt(chain, (static_cast<float>(k) + 0.5f) * step, step, piece);
      if (state == run) continue;
      AddLine(chain, run, run_begin, static_cast<float>(k) * step);
      run = state;
      run_begin = static_cast<float>(k) * step;
    }
    AddLine(chain, run, run_begin, length);
  }

  const Eigen::Vector2f& Pixel(const Chain& chain, std::size_t i) const {
    return pixels_[static_cast<std::size_t>(chain.vertices[i])];
  }

  /// The pixel at `arc`, in the piece from vertex `piece` on.
  Eigen::Vector2f On(const Chain& chain, std::size_t piece, float arc) const {
    const float length = std::max(arc_[piece + 1] - arc_[piece], 1e-6f);
    const float t = std::clamp((arc - arc_[piece]) / length, 0.0f, 1.0f);
    return (1 - t) * Pixel(chain, piece) + t * Pixel(chain, piece + 1);
  }

  /// Normals differ from edge to edge of a finely or roughly meshed surface: their mean.
  Eigen::Vector2f NormalAround(const Chain& chain, std::size_t piece, float arc) const {
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    const float low = arc - kSmooth_px, high = arc + kSmooth_px;
    std::size_t i = piece;
    while (i > 0 && arc_[i] > low) --i;
    for (; i < chain.normals.size() && arc_[i] < high; ++i) {
      sum +=
          std::max(0.0f, std::min(arc_[i + 1], high) - std::max(arc_[i], low)) * chain.normals[i];
    }
    return sum.norm() > 1e-3f ? Eigen::Vector2f(sum.normalized()) : chain.normals[piece];
  }

  State SampleAt(const Chain& chain, float arc, float step, std::size_t& piece) {
    while (piece + 2 < arc_.size() && arc_[piece + 1] < arc) ++piece;
    OutlineSample sample;
    sample.pixel = On(chain, piece, arc);
    if ((sample.pixel.array() < 0).any() || (sample.pixel.array() > limit_.array()).any()) {
      return State::kGone;
    }
    sample.normal = NormalAround(chain, piece, arc);
    sample.kind = chain.kind;
    sample.length_px = step;
    const float length = std::max(arc_[piece + 1] - arc_[piece], 1e-6f);
    const float t = (arc - arc_[piece]) / length;
    const float inverse_depth =
        (1 - t) / in_cam_[static_cast<std::size_t>(chain.vertices[piece])].z() +
        t / in_cam_[static_cast<std::size_t>(chain.vertices[piece + 1])].z();
    const float depth = 1.0f / inverse_depth;
    if (!ShowsItself(sample, depth)) return State::kGone;
    const Eigen::Vector2f bearing = ToBearing(sample.pixel);
    sample.in_object =
        object_from_cam_ * Eigen::Vector3f(depth * bearing.x(), depth * bearing.y(), depth);
    sample.hidden = others_.Hides(bearing, depth);
    outline_.samples.push_back(sample);
    return sample.hidden ? State::kHidden : State::kVisible;
  }

  /// Whether the model does not hide the sample, and, of a contour, whether what lies beyond it is
  /// far behind: a fold in a rough surface is no contour.
  bool ShowsItself(const OutlineSample& sample, float depth) const {
    const bool contour = sample.kind == OutlineKind::kContour;
    const Eigen::Vector2f bearing = ToBearing(
        contour ? Eigen::Vector2f(sample.pixel + kBeyond_px * sample.normal) : sample.pixel);
    const float hit =
        model_.rays()
            .Cast(object_from_cam_.translation(),
                  object_from_cam_.linear() * Eigen::Vector3f(bearing.x(), bearing.y(), 1.0f))
            .distance;
    if (contour) return hit == 0 || hit > depth + step_m_;
    return hit == 0 || hit > depth - 0.25f * step_m_;
  }

  void AddLine(const Chain& chain, State state, float begin, float end) {
    if (state == State::kGone || end <= begin) return;
    OutlinePolyline line{chain.kind, state == State::kHidden, {}};
    const std::size_t first =
        static_cast<std::size_t>(std::upper_bound(arc_.begin(), arc_.end(), begin) - arc_.begin());
    std::size_t i = std::min(first, arc_.size() - 1);
    line.pixels.push_back(On(chain, i - 1, begin));
    for (; i + 1 < arc_.size() && arc_[i] < end; ++i) line.pixels.push_back(Pixel(chain, i));
    line.pixels.push_back(On(chain, i - 1, end));
    outline_.lines.push_back(std::move(line));
  }

  const OutlineModel& model_;
  Eigen::Isometry3f cam_from_object_, object_from_cam_;
  Eigen::Vector2f focal_, principal_, limit_;
  float step_px_, step_m_;
  OcclusionTest others_;
  std::vector<Eigen::Vector3f> in_cam_;
  std::vector<Eigen::Vector2f> pixels_;
  std::vector<float> arc_;  ///< Of the chain at hand, at its vertices [px].
  ModelOutline outline_;
};

}  // namespace

ModelOutline ProjectOutline(const OutlineModel& model, const Eigen::Isometry3d& scan_from_object,
                            const Eigen::Isometry3d& scan_from_cam, const PinholeCamera& camera,
                            const Occluders& occluders, const OutlineOptions& options) {
  return Projector(model, scan_from_object, scan_from_cam, camera, occluders, options).Run();
}

}  // namespace plumbline
