// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <Eigen/Core>

#include "engine/snapshot/run_history.h"

namespace plumbline {

/// Whether the filter knows what it does not know: what it claimed in the frames of a run, against
/// ground truth. Frames of one object resemble one another, so a few hundred of them are far fewer
/// independent trials.
struct Calibration {
  int poses = 0;                     ///< Objects in frames, with a true object to compare with.
  int within_50 = 0, within_95 = 0;  ///< Of these: the truth lies in that region of the belief.
  /// By how surely the most likely shape was believed: how often that was the true one.
  struct Bin {
    double above = 0;  ///< Probability of the bin's lower edge; up to that of the next bin.
    int labels = 0, right = 0;
    double claimed = 0;  ///< Sum of the probabilities.
  };
  std::array<Bin, 5> bins = {{{0}, {0.5}, {0.7}, {0.9}, {0.99}}};

  int labels() const;
  int right() const;
  double claimed() const;  ///< Mean probability of the most likely shape; 0 without any.
};

/// Counts confirmed objects in the frames in which they were weighed and lie within
/// kCalibrationReach_m of a true object of their category.
/// @param only  This object alone; not valid: all.
Calibration CalibrationOf(const RunHistory& history, ObjectId only = {});
inline constexpr float kCalibrationReach_m = 0.5f;

/// Share of a Gaussian belief that is likelier than the truth, in [0, 1]: the truth lies in the 95
/// % region if it is at most 0.95. Ground truth is taken to be exact to 3 mm and half a degree.
/// @param offset      Truth minus mean: x, y, z [m], azimuth [rad].
/// @param covariance  Of the belief, in the same order.
/// @param round       The azimuth says nothing.
double CredibleLevel(const Eigen::Vector4d& offset, const Eigen::Matrix4d& covariance, bool round);

}  // namespace plumbline
