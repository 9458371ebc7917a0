// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/honest_nees.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/check.h"
#include "engine/base/random.h"

namespace plumbline {
namespace {

constexpr int kDimensions = 4;
constexpr std::size_t kRuns = 2000, kBelow = 50;  // 2.5 % of them

/// Half of a chi-square variable: a sum of exponential ones.
double DrawHalfChiSquare(int degrees_of_freedom, Random& random) {
  double product = 1;
  for (int i = 0; i < degrees_of_freedom / 2; ++i) product *= 1 - random.Uniform();
  return -std::log(product);
}

}  // namespace

NeesInterval HonestMeanNees(int objects, int degrees_of_freedom) {
  PLB_CHECK(objects >= 1 && degrees_of_freedom > 2 && degrees_of_freedom % 2 == 0)
      << objects << " objects, " << degrees_of_freedom;
  Random random({.seed = 1});
  std::vector<double> means(kRuns);
  for (double& mean : means) {
    for (int i = 0; i < objects; ++i) {
      const double squared = DrawHalfChiSquare(kDimensions, random);
      mean += (degrees_of_freedom - 2) * squared / DrawHalfChiSquare(degrees_of_freedom, random);
    }
    mean /= objects;
  }
  const auto rank = [&](std::size_t place) {
    std::nth_element(means.begin(), means.begin() + static_cast<std::ptrdiff_t>(place),
                     means.end());
    return means[place];
  };
  return {rank(kBelow), rank(kRuns - 1 - kBelow)};
}

}  // namespace plumbline
