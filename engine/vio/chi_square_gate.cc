// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/chi_square_gate.h"

#include <cmath>

namespace plumbline {

ChiSquareGate::ChiSquareGate(double probability) {
  double low = -9, high = 9;
  for (int i = 0; i < 80; ++i) {
    const double middle = (low + high) / 2;
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < probability ? low : high) = middle;
  }
  normal_quantile_ = low;
}

double ChiSquareGate::operator()(int dof) const {
  const double s = 2.0 / (9 * dof), root = 1 - s + normal_quantile_ * std::sqrt(s);
  return dof * root * root * root;
}

}  // namespace plumbline
