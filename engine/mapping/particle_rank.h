// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "engine/mapping/map_report.h"

namespace plumbline {

/// Indices of an object's particles, the best first: by weight times what the last frame says of
/// them. (After resampling all weigh the same; then the better score goes first.)
/// @param alpha, beta  Of the mapper's options: what the two terms count.
std::vector<int> ByRank(std::span<const Particle> particles, double alpha, double beta);

}  // namespace plumbline
