// SPDX-License-Identifier: Apache-2.0
#include "engine/snapshot/relations.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kVertices = 400;
constexpr double kTouch_m = 0.06;       ///< What stands on something is this close to its top,
constexpr double kOverhang_m = 0.05;    ///< and its centre at most this far outside.
constexpr double kLeastHeight_m = 0.1;  ///< A carpet carries nothing.
constexpr double kOcclusionMargin_m = 0.05;
constexpr double kLeastHidden = 0.05;

struct Body {
  ObjectId id;
  Eigen::Isometry3d world_from_object;
  Eigen::AlignedBox3d box;         ///< In the object's frame.
  std::vector<Vector3d> vertices;  ///< In the world.
  double low = 1e9, high = -1e9;   ///< Along up.
};

std::vector<Body> BodiesOf(const FrameReport& report, const SequenceView& view) {
  std::vector<Body> bodies;
  for (const ObjectReport& object : report.objects) {
    const auto label = static_cast<std::size_t>(object.label.value);
    if (object.state != ObjectState::kConfirmed || label >= view.models.size()) continue;
    const auto& mesh = view.models[label].mesh;
    if (mesh == nullptr || mesh->vertices.empty()) continue;
    Body body{object.id, object.world_from_object, BoundingBox(*mesh).cast<double>(), {}};
    const std::size_t stride = std::max<std::size_t>(1, mesh->vertices.size() / kVertices);
    for (std::size_t i = 0; i < mesh->vertices.size(); i += stride)
      body.vertices.push_back(object.world_from_object * mesh->vertices[i].cast<double>());
    for (const Vector3d& p : body.vertices) {
      body.low = std::min(body.low, p.dot(view.up_in_world));
      body.high = std::max(body.high, p.dot(view.up_in_world));
    }
    bodies.push_back(std::move(body));
  }
  return bodies;
}

/// From the vertices of one to the box of the other, the smaller way.
double Gap(const Body& a, const Body& b) {
  const auto one_way = [](const Body& from, const Body& to) {
    const Eigen::Isometry3d inside = to.world_from_object.inverse();
    double least = 1e9;
    for (const Vector3d& p : from.vertices)
      least = std::min(least, to.box.exteriorDistance(inside * p));
    return least;
  };
  return std::min(one_way(a, b), one_way(b, a));
}

std::optional<double> StandsOn(const Body& a, const Body& b) {
  const double gap = a.low - b.high;
  if (std::abs(gap) > kTouch_m || b.high - b.low < kLeastHeight_m) return std::nullopt;
  const Vector3d inside = b.world_from_object.inverse() * (a.world_from_object * a.box.center());
  const bool above =
      inside.x() > b.box.min().x() - kOverhang_m && inside.x() < b.box.max().x() + kOverhang_m &&
      inside.y() > b.box.min().y() - kOverhang_m && inside.y() < b.box.max().y() + kOverhang_m;
  return above ? std::optional(std::max(0.0, gap)) : std::nullopt;
}

/// What the Z-buffer shows instead of `hidden`.
void AddHiders(const Body& hidden, const std::vector<Body>& bodies, const FrameReport& report,
               const SequenceView& view, const cv::Mat& depth, const cv::Mat& id,
               std::vector<ObjectRelation>& relations) {
  if (depth.empty() || id.empty() || !report.world_from_cam || view.image_width == 0) return;
  const Eigen::Isometry3d cam_from_world = report.world_from_cam->inverse();
  const double scale_x = double(depth.cols) / view.image_width;
  const double scale_y = double(depth.rows) / view.image_height;
  std::vector<std::pair<int, int>> counts;
  int in_view = 0;
  for (const Vector3d& vertex : hidden.vertices) {
    const Vector3d p = cam_from_world * vertex;
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
  for (const auto& [other, count] : counts) {
    const double share = double(count) / in_view;
    const bool confirmed = std::any_of(bodies.begin(), bodies.end(),
                                       [&](const Body& body) { return body.id.value == other; });
    if (confirmed && share >= kLeastHidden)
      relations.push_back({RelationKind::kHides, {other}, hidden.id, share});
  }
}

}  // namespace

std::vector<ObjectRelation> RelationsOf(const FrameReport& report, const SequenceView& view,
                                        const cv::Mat& depth, const cv::Mat& id) {
  const std::vector<Body> bodies = BodiesOf(report, view);
  std::vector<ObjectRelation> near, stands, hides;
  for (const Body& a : bodies) {
    ObjectRelation nearest{RelationKind::kNear, a.id, {}, 1e9};
    for (const Body& b : bodies) {
      if (a.id == b.id) continue;
      if (const auto gap = StandsOn(a, b))
        stands.push_back({RelationKind::kStandsOn, a.id, b.id, *gap});
      const double gap = Gap(a, b);
      if (gap < nearest.value) nearest = {RelationKind::kNear, a.id, b.id, gap};
    }
    if (nearest.b.value > 0) near.push_back(nearest);
    AddHiders(a, bodies, report, view, depth, id, hides);
  }
  std::vector<ObjectRelation> all = std::move(stands);
  all.insert(all.end(), hides.begin(), hides.end());
  all.insert(all.end(), near.begin(), near.end());
  return all;
}

const char* RelationName(RelationKind kind) {
  switch (kind) {
    case RelationKind::kNear:
      return "is nearest to";
    case RelationKind::kStandsOn:
      return "stands on";
    case RelationKind::kHides:
      return "hides";
  }
  return "";
}

}  // namespace plumbline
