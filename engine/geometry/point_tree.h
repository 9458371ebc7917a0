// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace plumbline {

/// Nearest neighbours among fixed points (a k-d tree). Immutable; safe to use from several threads.
class PointTree {
 public:
  struct Neighbor {
    int index = -1;  ///< -1 where there is no point at all
    float squared_distance = 0;
  };

  explicit PointTree(std::vector<Eigen::Vector3f> points);
  ~PointTree();
  PointTree(PointTree&&) noexcept;
  PointTree& operator=(PointTree&&) noexcept;

  const std::vector<Eigen::Vector3f>& points() const;
  Neighbor Nearest(const Eigen::Vector3f& query) const;
  /// The `count` nearest (fewer where there are fewer), nearest first.
  std::vector<Neighbor> Nearest(const Eigen::Vector3f& query, int count) const;
  /// All closer than `radius_m`, by rising index.
  std::vector<int> Within(const Eigen::Vector3f& query, float radius_m) const;

 private:
  class Implementation;
  std::unique_ptr<const Implementation> implementation_;
};

}  // namespace plumbline
