// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/truth_pairing.h"

#include <limits>

#include "engine/geometry/assignment.h"

namespace plumbline {

std::vector<std::optional<int>> PairWithTruth(std::span<const PlacedThing> estimates,
                                              std::span<const PlacedThing> truths, double reach_m) {
  Eigen::MatrixXd cost =
      Eigen::MatrixXd::Constant(static_cast<int>(estimates.size()), static_cast<int>(truths.size()),
                                std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    for (std::size_t j = 0; j < truths.size(); ++j) {
      if (estimates[i].category != truths[j].category) continue;
      const double distance_m = (estimates[i].origin - truths[j].origin).norm();
      if (distance_m <= reach_m) cost(static_cast<int>(i), static_cast<int>(j)) = distance_m;
    }
  }
  return AssignOneToOne(cost);
}

}  // namespace plumbline
