// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/relations.h"

#include <algorithm>
#include <cmath>

#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr double kTouch_m = 0.06;       ///< What stands on something is this close to its top,
constexpr double kOverhang_m = 0.05;    ///< and its centre at most this far outside.
constexpr double kLeastHeight_m = 0.1;  ///< A carpet carries nothing.
constexpr double kOcclusionMargin_m = 0.05;
constexpr double kLeastHidden = 0.05;

/// What the Z-buffer shows instead of `hidden`.
template <typename Body>
void AddHiders(const Body& hidden, const std::vector<Body>& bodies, const FrameReport& report,
               const SequenceView& view, const cv::Mat& depth, const cv::Mat& id,
               std::vector<ObjectRelation>& relations) {
  if (depth.empty() || id.empty() || !report.world_from_cam || view.image_width == 0) return;
  const Eigen::Isometry3d cam_from_world = report.world_from_cam->inverse();
  const double scale_x = double(depth.cols) / view.image_width;
  const double scale_y = double(depth.rows) / view.image_height;
  std::vector<std::pair<int, int>> counts;
  int in_view = 0;
  const Eigen::Affine3d cam_from_object = cam_from_world * hidden.placed().world_from_mesh();
  for (const Vector3d& point : hidden.surface->points()) {
    const Vector3d p = cam_from_object * point;
    if (p.z() < 0.05) continue;
    const int x = static_cast<int>(std::floor((view.fx * p.x() / p.z() + view.cx + 0.5) * scale_x));
    const int y = static_cast<int>(std::floor((view.fy * p.y() / p.z() + view.cy + 0.5) * scale_y));
    if (x < 0 || y < 0 || x >= depth.cols || y >= depth.rows) continue;
    ++in_view;
    const int other = id.at<std::uint16_t>(y, x);
    if (other == 0 || other == hidden.id.value ||
        depth.at<float>(y, x) > p.z() - kOcclusionMargin_m)
      continue;
    const auto found = std::find_if(counts.begin(), counts.end(),
                                    [&](const auto& count) { return count.first == other; });
    if (found == counts.end())
      counts.emplace_back(other, 1);
    else
      ++found->second;
  }
  for (const auto& count : counts) {
    const double share = double(count.second) / in_view;
    const bool confirmed = std::any_of(bodies.begin(), bodies.end(), [&](const Body& body) {
      return body.id.value == count.first;
    });
    if (confirmed && share >= kLeastHidden)
      relations.push_back({RelationKind::kHides, {count.first}, hidden.id, share});
  }
}

}  // namespace

struct RelationFinder::Body {
  ObjectId id;
  ModelId label;
  Eigen::Isometry3d world_from_object;
  double scale;
  std::shared_ptr<const MeasuredSurface> surface;
  double low = 1e9, high = -1e9;  ///< Along up.

  PlacedSurface placed() const { return {*surface, world_from_object, scale}; }
  /// Around it, in its own frame.
  Eigen::AlignedBox3d box() const {
    return {scale * surface->box().min(), scale * surface->box().max()};
  }
  /// Above `other`'s footprint, and as high as its top.
  bool StandsOn(const Body& other) const {
    if (std::abs(low - other.high) > kTouch_m || other.high - other.low < kLeastHeight_m)
      return false;
    const Vector3d inside =
        other.world_from_object.inverse() * (world_from_object * box().center());
    Eigen::AlignedBox3d around = other.box();
    around.min().array() -= kOverhang_m;
    around.max().array() += kOverhang_m;
    return inside.x() > around.min().x() && inside.x() < around.max().x() &&
           inside.y() > around.min().y() && inside.y() < around.max().y();
  }
};

std::vector<RelationFinder::Body> RelationFinder::BodiesOf(const FrameReport& report,
                                                           const SequenceView& view) {
  std::vector<Body> bodies;
  for (const ObjectReport& object : report.objects) {
    const auto label = static_cast<std::size_t>(object.label.value);
    if (object.state != ObjectState::kConfirmed || label >= view.models.size()) continue;
    const auto& mesh = view.models[label].mesh;
    if (mesh == nullptr) continue;
    const auto [found, is_new] = surfaces_.try_emplace(mesh);
    if (is_new) {
      if (auto made = MeasuredSurface::Make(*mesh); made.ok()) found->second = std::move(*made);
    }
    if (found->second == nullptr) continue;  // a mesh without area is nowhere
    Body body{object.id, object.label, object.world_from_object, object.scale, found->second};
    for (int i = 0; i < 8; ++i) {
      const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(i);
      const double height =
          (body.world_from_object * body.box().corner(corner)).dot(view.up_in_world);
      body.low = std::min(body.low, height);
      body.high = std::max(body.high, height);
    }
    bodies.push_back(std::move(body));
  }
  return bodies;
}

double RelationFinder::GapOf(const Body& a, const Body& b) {
  if (b.id < a.id) return GapOf(b, a);
  const Eigen::Affine3d b_from_a =
      b.placed().world_from_mesh().inverse() * a.placed().world_from_mesh();
  const auto [known, is_new] = gaps_.try_emplace({a.id, b.id});
  Gap& gap = known->second;
  if (!is_new && gap.label_a == a.label && gap.label_b == b.label && gap.scale_b == b.scale &&
      gap.b_from_a.isApprox(b_from_a, 1e-12))
    return gap.gap_m;
  gap = {a.label, b.label, b_from_a, b.scale, SurfaceGap(a.placed(), b.placed())};
  return gap.gap_m;
}

/// Only those are measured that could be nearer than the nearest so far.
const RelationFinder::Body* RelationFinder::NearestOf(const Body& a,
                                                      const std::vector<Body>& bodies,
                                                      double& gap_m) {
  std::vector<std::pair<double, const Body*>> others;
  for (const Body& b : bodies) {
    if (b.id == a.id) continue;
    others.emplace_back(GapAtLeast(a.placed(), b.placed()), &b);
  }
  std::sort(others.begin(), others.end());
  const Body* nearest = nullptr;
  for (const auto& [at_least, b] : others) {
    if (nearest != nullptr && at_least >= gap_m) break;
    const double gap = GapOf(a, *b);
    if (nearest != nullptr && gap >= gap_m) continue;
    nearest = b;
    gap_m = gap;
  }
  return nearest;
}

std::vector<ObjectRelation> RelationFinder::Find(const FrameReport& report,
                                                 const SequenceView& view, const cv::Mat& depth,
                                                 const cv::Mat& id) {
  // Meshes of a sequence that is no longer open.
  std::erase_if(surfaces_, [](const auto& entry) { return entry.first.use_count() == 1; });
  const std::vector<Body> bodies = BodiesOf(report, view);
  std::erase_if(gaps_, [&](const auto& gap) {
    return std::none_of(bodies.begin(), bodies.end(),
                        [&](const Body& body) { return body.id == gap.first.first; });
  });
  std::vector<ObjectRelation> all, near, hides;
  for (const Body& a : bodies) {
    for (const Body& b : bodies) {
      if (a.id != b.id && a.StandsOn(b))
        all.push_back({RelationKind::kStandsOn, a.id, b.id, GapOf(a, b)});
    }
    double gap_m = 0;
    if (const Body* nearest = NearestOf(a, bodies, gap_m))
      near.push_back({RelationKind::kNear, a.id, nearest->id, gap_m});
    AddHiders(a, bodies, report, view, depth, id, hides);
  }
  all.insert(all.end(), hides.begin(), hides.end());
  all.insert(all.end(), near.begin(), near.end());
  return all;
}

}  // namespace plumbline
