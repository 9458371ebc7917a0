// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "engine/base/random.h"

namespace plumbline {

/// Independent standard normal coordinates, the last one drawn first. (Arguments of a call are
/// evaluated in an order that each compiler chooses: `Vector3d(random.Gaussian(), ..)` would be
/// another vector with another compiler.)
template <int kSize>
Eigen::Matrix<double, kSize, 1> GaussianVector(Random& random) {
  Eigen::Matrix<double, kSize, 1> drawn;
  for (int k = kSize - 1; k >= 0; --k) drawn[k] = random.Gaussian();
  return drawn;
}

}  // namespace plumbline
