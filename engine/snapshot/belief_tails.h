// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// Degrees of freedom of the Student's t that a place is told as, with the covariance that is
/// reported of its object (mapping/map_report.h): by how much views err alike differs from one
/// object to the next, so errors are small more often than normal ones of that covariance, and
/// large, too (docs/algorithms/semantic_filter.md#tails).
inline constexpr int kBeliefDegreesOfFreedom = 4;

}  // namespace plumbline
