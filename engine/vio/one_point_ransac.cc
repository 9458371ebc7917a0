// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/one_point_ransac.h"

#include <limits>

#include <Eigen/LU>

namespace plumbline {

std::vector<bool> OnePointConsensus(const Eigen::VectorXd& residual,
                                    const Eigen::MatrixXd& projected, double threshold) {
  const Eigen::Index count = residual.size() / 2;
  std::vector<bool> best(static_cast<std::size_t>(count), false);
  Eigen::Index best_count = 0;
  double best_sum = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < count; ++i) {
    // By the update with measurement i alone all others' innovations are known: linear algebra.
    const Eigen::Matrix2d innovation =
        projected.block<2, 2>(2 * i, 2 * i) + Eigen::Matrix2d::Identity();
    const Eigen::VectorXd left = residual - projected.middleCols<2>(2 * i) *
                                                (innovation.inverse() * residual.segment<2>(2 * i));
    std::vector<bool> agrees(best.size());
    Eigen::Index number = 0;
    double sum = 0;
    for (Eigen::Index k = 0; k < count; ++k) {
      const double square = left.segment<2>(2 * k).squaredNorm();
      agrees[static_cast<std::size_t>(k)] = square < threshold;
      if (square < threshold) {
        ++number;
        sum += square;
      }
    }
    if (number > best_count || (number == best_count && sum < best_sum)) {
      best = std::move(agrees);
      best_count = number;
      best_sum = sum;
    }
  }
  return best;
}

}  // namespace plumbline
