// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the truth lies in a belief about (x, y, z of the centre in world [m], azimuth [rad]).
// Formulas: docs/algorithms/evaluation.md.

#include <span>

#include <Eigen/Core>

namespace plumbline {

/// One of the places where an object may be: a Gaussian, or Student's t of the same covariance.
struct BeliefMode {
  double weight = 1;  ///< Relative to the others.
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  double degrees_of_freedom = 0;  ///< Of Student's t, more than 2; 0: a Gaussian.
  int symmetry_order = 1;         ///< Looks the same turned by 360 degrees / this; 0: round.
};

/// The truth, and one standard deviation of how well it is known.
struct TrueState {
  Eigen::Vector4d state = Eigen::Vector4d::Zero();
  double position_std_m = 0;  ///< Root of the mean squared distance: 1 / sqrt(3) of it an axis.
  double azimuth_std_rad = 0;
  int symmetry_order = 1;  ///< As above; 0: only the position is compared.
};

/// Share of the belief that is likelier than the truth, in [0, 1]: the truth lies in the 95 %
/// highest-density region of the mixture if this is at most 0.95. The truth's own deviation is
/// added to that of every mode. Exact for one mode, if it is a Gaussian or the truth is exact; else
/// by 512 fixed draws.
/// @param modes  At least one; weights >= 0 with a positive sum.
double CredibleLevel(std::span<const BeliefMode> modes, const TrueState& truth);

/// Normalised estimation error squared: on average the degrees of freedom if the belief is honest,
/// and chi-square distributed if it is a Gaussian.
struct Nees {
  double value = 0;
  int degrees_of_freedom = 4;  ///< 3 where the azimuth says nothing.
};
Nees NeesOf(const BeliefMode& mode, const TrueState& truth);

}  // namespace plumbline
