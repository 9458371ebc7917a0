// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace plumbline {

/// Why assimp 5.2 would not survive a COLLADA text, in words that follow "the file is damaged: ";
/// "" where nothing of that kind was found. It takes counts at their word, looks beyond the numbers
/// that an accessor has, and makes zeros without end of an index that is no number.
std::string ColladaProblem(std::string_view text);

}  // namespace plumbline
