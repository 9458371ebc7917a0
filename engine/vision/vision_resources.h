// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace plumbline {

/// A file of assets/networks that is built into the program. It must be there.
std::string VisionResource(std::string_view name);

}  // namespace plumbline
