// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "engine/base/random.h"

namespace plumbline::fuzz {

/// The input with one to four small things changed, by what it is: a value, key or element of JSON;
/// a line or a number of a table; bytes of anything else. Of several files (packed_files.h) one is
/// changed, or goes. The same random numbers give the same result.
std::string Mutate(std::string_view input, Random& random);

}  // namespace plumbline::fuzz
