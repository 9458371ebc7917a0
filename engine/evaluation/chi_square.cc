// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/chi_square.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace plumbline {

double ChiSquareCdf(double x, int dof) {
  PLB_CHECK(dof >= 1) << dof;
  if (x <= 0) return 0;
  // Q(k + 2) = Q(k) + (x/2)^(k/2) exp(-x/2) / Gamma(k/2 + 1), from Q(1) or Q(2) on.
  double tail = dof % 2 == 1 ? std::erfc(std::sqrt(0.5 * x)) : std::exp(-0.5 * x);
  for (int k = dof % 2 == 1 ? 1 : 2; k < dof; k += 2)
    tail += std::exp(0.5 * k * std::log(0.5 * x) - 0.5 * x - std::lgamma(0.5 * k + 1));
  return std::clamp(1 - tail, 0.0, 1.0);
}

double ChiSquareQuantile(double p, int dof) {
  PLB_CHECK(p >= 0 && p < 1) << p;
  double low = 0, high = dof;
  while (ChiSquareCdf(high, dof) < p) high *= 2;
  while (high - low > 1e-9 * high) {
    const double middle = 0.5 * (low + high);
    (ChiSquareCdf(middle, dof) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace plumbline
