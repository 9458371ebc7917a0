// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/particle_rank.h"

#include <algorithm>
#include <numeric>

namespace plumbline {

std::vector<int> ByRank(std::span<const Particle> particles, double alpha, double beta) {
  std::vector<int> order(particles.size());
  std::iota(order.begin(), order.end(), 0);
  const auto score = [&](int i) {
    const Particle& p = particles[static_cast<std::size_t>(i)];
    return p.log_weight + alpha * p.phi_cnn + beta * p.phi_edge;
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return score(a) > score(b); });
  return order;
}

}  // namespace plumbline
