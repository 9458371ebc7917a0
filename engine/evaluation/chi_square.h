// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// Probability that the sum of squares of `dof` independent standard normal numbers is at most x.
/// @param dof  Degrees of freedom, >= 1. Cost grows with them.
double ChiSquareCdf(double x, int dof);

/// The x for which ChiSquareCdf(x, dof) = p, to 1e-9 of itself; 0 <= p < 1.
double ChiSquareQuantile(double p, int dof);

}  // namespace plumbline
