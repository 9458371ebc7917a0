// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/base/result.h"

namespace plumbline {

struct TrajectoryArguments {
  std::string estimate, reference;  ///< TUM files, or rows as groundtruth.csv has (named *.csv).
  std::string align = "yaw";        ///< none, yaw, se3 or sim3.
  std::string json;                 ///< Empty: none; -: to standard output, instead of the table.
};

/// Compares a trajectory with a reference and prints the errors. Covariances are read from
/// EST.covariance.csv where there is one. Errors: kNotFound, kCorrupt, kDegenerate.
Status EvaluateTrajectory(const TrajectoryArguments& arguments);

}  // namespace plumbline
