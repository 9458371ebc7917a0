// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace plumbline {

/// Estimates further than this from an instance are not it.
inline constexpr double kPairReach_m = 0.5;

/// An object of a map, or a true instance.
struct PlacedThing {
  std::string_view category;
  Eigen::Vector3d origin{0, 0, 0};  ///< Both in one frame [m].
};

/// Pairs estimates with true instances, one to one: as many pairs of a category within `reach_m` as
/// there can be, and among those the smallest sum of distances (docs/algorithms/evaluation.md).
/// Entry i: the instance of estimate i.
std::vector<std::optional<int>> PairWithTruth(std::span<const PlacedThing> estimates,
                                              std::span<const PlacedThing> truths, double reach_m);

}  // namespace plumbline
