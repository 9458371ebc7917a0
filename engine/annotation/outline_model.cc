// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/outline_model.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <unordered_map>
#include <utility>

#include <Eigen/Geometry>

#include "engine/models/mesh_cleanup.h"

namespace plumbline {
namespace {

/// The piece of `corner - begin` that stands square on the edge's direction, of unit length.
Eigen::Vector3f Across(const Eigen::Vector3f& begin, const Eigen::Vector3f& along,
                       const Eigen::Vector3f& corner) {
  const Eigen::Vector3f out = corner - begin;
  return (out - out.dot(along) * along).normalized();
}

/// Joins vertices into connected sets.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int Find(int i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      int& parent = parent_[static_cast<std::size_t>(i)];
      parent = parent_[static_cast<std::size_t>(parent)];
      i = parent;
    }
    return i;
  }
  void Join(int a, int b) { parent_[static_cast<std::size_t>(Find(a))] = Find(b); }

 private:
  std::vector<int> parent_;
};

}  // namespace

Result<std::shared_ptr<const OutlineModel>> OutlineModel::Prepare(
    const TriangleMesh& mesh, const OutlineModelOptions& options) {
  const std::shared_ptr<OutlineModel> model(new OutlineModel);
  model->mesh_ = WeldedGeometry(mesh);
  auto surface = ClosestTriangleSearch::Build(model->mesh_);
  if (!surface) return surface.error();
  model->surface_ = std::move(*surface);
  model->rays_ = std::make_unique<RayScene>(model->mesh_);
  model->center_ = BoundingBox(model->mesh_).center();
  for (const Eigen::Vector3f& vertex : model->mesh_.vertices) {
    model->radius_ = std::max(model->radius_, (vertex - model->center_).norm());
  }
  model->FindEdges();
  model->FindCreases(options);
  return std::shared_ptr<const OutlineModel>(model);
}

void OutlineModel::FindEdges() {
  std::unordered_map<std::uint64_t, std::size_t> known;
  for (const Eigen::Vector3i& corners : mesh_.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = corners[k], b = corners[(k + 1) % 3], c = corners[(k + 2) % 3];
      const auto [low, high] = std::minmax(a, b);
      const std::uint64_t key = static_cast<std::uint64_t>(low) << 32 | static_cast<unsigned>(high);
      const auto [place, is_new] = known.try_emplace(key, edges_.size());
      if (is_new) {
        edges_.push_back({low, high, c, -1, false});
      } else if (Edge& edge = edges_[place->second]; edge.opposite2 < 0) {
        edge.opposite2 = c;
      }  // Of three faces and more at one edge the first two are looked at.
    }
  }
}

void OutlineModel::FindCreases(const OutlineModelOptions& options) {
  const float flat =
      -static_cast<float>(std::cos(options.crease_angle_deg * std::numbers::pi / 180));
  const auto at = [&](int i) -> const Eigen::Vector3f& {
    return mesh_.vertices[static_cast<std::size_t>(i)];
  };
  Sets sets(mesh_.vertices.size());
  for (Edge& edge : edges_) {
    if (edge.opposite2 < 0) continue;
    const Eigen::Vector3f& begin = at(edge.begin);
    const Eigen::Vector3f along = (at(edge.end) - begin).normalized();
    const float bend =
        Across(begin, along, at(edge.opposite)).dot(Across(begin, along, at(edge.opposite2)));
    edge.crease = bend > flat;
    if (edge.crease) sets.Join(edge.begin, edge.end);
  }
  std::vector<float> length(mesh_.vertices.size(), 0);
  for (const Edge& edge : edges_) {
    if (!edge.crease) continue;
    length[static_cast<std::size_t>(sets.Find(edge.begin))] +=
        (at(edge.end) - at(edge.begin)).norm();
  }
  const float shortest = static_cast<float>(options.min_crease_length) * radius_;
  for (Edge& edge : edges_) {
    edge.crease =
        edge.crease && length[static_cast<std::size_t>(sets.Find(edge.begin))] >= shortest;
  }
}

}  // namespace plumbline
