// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/base/result.h"

namespace plumbline {

/// `annotate queue`: the scans and projects of a folder, and how far each is.
Status ShowQueue(const std::string& folder, const std::string& json_file);

}  // namespace plumbline
