// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "engine/models/thing_table.h"

namespace plumbline {

/// Log-likelihood of one length [m] beside the usual one, 0 at best: Student's t (5 degrees of
/// freedom) in the logarithm, since odd sizes are not as rare as the normal law says.
double LogFit(double length_m, double usual_m, double spread);

/// The same of height, width and depth, when `up` is the index of the axis that points up. Which of
/// the others is the width is not known: the better of both.
double LogFitStanding(const Eigen::Vector3d& size_m, int up, const Thing& thing);

}  // namespace plumbline
