// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// How large a normalised innovation squared may be.
class ChiSquareGate {
 public:
  /// @param probability  Of an honest measurement to pass, in (0, 1).
  explicit ChiSquareGate(double probability);

  /// The quantile for `dof` >= 1 degrees of freedom, by Wilson and Hilferty (1931): within 4 % of
  /// it for one degree of freedom at the 95 % point, within 0.6 % from three on.
  double operator()(int dof) const;

 private:
  double normal_quantile_;
};

}  // namespace plumbline
