// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/point_tree.h"

#include <algorithm>
#include <utility>

#include <nanoflann.hpp>

namespace plumbline {
namespace {

/// What nanoflann asks of its points.
struct Adaptor {
  std::vector<Eigen::Vector3f> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t dimension) const {
    return points[index][static_cast<Eigen::Index>(dimension)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Adaptor>, Adaptor, 3>;
/// Takes all within a radius; the same for every version of nanoflann.
struct Collector {
  float squared_radius;
  std::vector<int>& indices;

  bool full() const { return true; }
  bool empty() const { return indices.empty(); }
  std::size_t size() const { return indices.size(); }
  float worstDist() const { return squared_radius; }
  void sort() {}
  bool addPoint(float squared_distance, std::size_t index) {
    if (squared_distance < squared_radius) indices.push_back(static_cast<int>(index));
    return true;
  }
};

constexpr std::size_t kPointsPerLeaf = 12;

}  // namespace

class PointTree::Implementation {
 public:
  explicit Implementation(std::vector<Eigen::Vector3f> points)
      : adaptor{std::move(points)},
        tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(kPointsPerLeaf)) {
    if (!adaptor.points.empty()) tree.buildIndex();
  }

  Adaptor adaptor;
  Tree tree;
};

PointTree::PointTree(std::vector<Eigen::Vector3f> points)
    : implementation_(std::make_unique<Implementation>(std::move(points))) {}
PointTree::~PointTree() = default;
PointTree::PointTree(PointTree&&) noexcept = default;
PointTree& PointTree::operator=(PointTree&&) noexcept = default;

const std::vector<Eigen::Vector3f>& PointTree::points() const {
  return implementation_->adaptor.points;
}

PointTree::Neighbor PointTree::Nearest(const Eigen::Vector3f& query) const {
  if (points().empty()) return {};
  std::size_t index = 0;
  float squared_distance = 0;
  nanoflann::KNNResultSet<float> result(1);
  result.init(&index, &squared_distance);
  implementation_->tree.findNeighbors(result, query.data(), {});
  return {static_cast<int>(index), squared_distance};
}

std::vector<PointTree::Neighbor> PointTree::Nearest(const Eigen::Vector3f& query, int count) const {
  const auto size = std::min(static_cast<std::size_t>(std::max(count, 0)), points().size());
  if (size == 0) return {};
  std::vector<std::size_t> indices(size);
  std::vector<float> distances(size);
  nanoflann::KNNResultSet<float> result(size);
  result.init(indices.data(), distances.data());
  implementation_->tree.findNeighbors(result, query.data(), {});
  std::vector<Neighbor> neighbors(size);
  for (std::size_t i = 0; i < size; ++i) {
    neighbors[i] = {static_cast<int>(indices[i]), distances[i]};
  }
  return neighbors;
}

std::vector<int> PointTree::Within(const Eigen::Vector3f& query, float radius_m) const {
  std::vector<int> indices;
  if (points().empty() || !(radius_m > 0)) return indices;
  Collector collector{radius_m * radius_m, indices};
  implementation_->tree.findNeighbors(collector, query.data(), {});
  std::sort(indices.begin(), indices.end());
  return indices;
}

}  // namespace plumbline
