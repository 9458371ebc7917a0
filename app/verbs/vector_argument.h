// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <Eigen/Core>

#include "engine/base/result.h"

namespace plumbline {

/// Between `least` and `most` numbers with commas between them: "1,2.5,-3". Errors: kInvalidInput,
/// beginning with `option`.
Result<Eigen::VectorXd> ParseNumbers(const std::string& text, const std::string& option, int least,
                                     int most);

/// Three numbers that are not all zero, scaled to length 1.
Result<Eigen::Vector3d> ParseDirection(const std::string& text, const std::string& option);

}  // namespace plumbline
