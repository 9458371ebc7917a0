// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

namespace plumbline {

/// Thresholds of the BOP benchmark: 0.05 .. 0.50 of the diameter or of 1, 5 .. 50 pixels at 640
/// pixels' width.
inline constexpr std::array<double, 10> kBopShares = {0.05, 0.10, 0.15, 0.20, 0.25,
                                                      0.30, 0.35, 0.40, 0.45, 0.50};
inline constexpr double kBopPixels = 100;  ///< Times a share: the threshold of MSPD [px].

/// The errors of one target that has an estimate.
struct BopErrors {
  std::vector<double> vsd;  ///< One for each of kBopShares as tau.
  double mssd_share = 0;    ///< Of the diameter.
  double mspd_at_640_px = 0;
};

/// Average recalls: shares of the targets that are right, over the thresholds.
struct BopRecall {
  int targets = 0, estimated = 0;
  double vsd = 0, mssd = 0, mspd = 0;  ///< Over all targets; those without an estimate are wrong.
  double average() const { return (vsd + mssd + mspd) / 3; }
};

/// @param targets  How many there are; `errors` holds those that have an estimate.
BopRecall BopRecallOf(const std::vector<BopErrors>& errors, int targets);

}  // namespace plumbline
