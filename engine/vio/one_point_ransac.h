// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace plumbline {

/// Which measurements of two rows each agree with one another, by one-point RANSAC for a filter
/// (Civera, Grasa, Davison and Montiel, J. Field Robotics 2010): one measurement corrects the whole
/// state, and those whose innovation it brings below the noise agree with it. Each one is tried, so
/// nothing is random; of equally many, the least sum of squares wins.
/// @param residual    Of all measurements, in units of their noise.
/// @param projected   jacobian * covariance * jacobian' of all rows: how they are correlated.
/// @param threshold   On the squared innovation left, in units of the noise's variance.
/// @return one for each measurement.
std::vector<bool> OnePointConsensus(const Eigen::VectorXd& residual,
                                    const Eigen::MatrixXd& projected, double threshold);

}  // namespace plumbline
