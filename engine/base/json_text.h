// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace plumbline {

/// Lists and objects of a JSON text may stand in one another this often: copying and writing a
/// value calls itself for each level, and a text of nothing but `[` would use up the stack.
inline constexpr int kDeepestJson = 200;

/// Whether a text nests more than kDeepestJson levels; // and /* comments are passed over.
bool IsTooDeep(std::string_view text);

/// A value of bytes that nobody vouches for; discarded (is_discarded) where it is no JSON or is too
/// deep.
nlohmann::json ParseJson(std::string_view text);

/// A whole number that fits. Throws std::range_error: get<int>() takes any number, and what becomes
/// of 4e200 is undefined.
int IntFromJson(const nlohmann::json& value);
std::uint64_t UnsignedFromJson(const nlohmann::json& value);

}  // namespace plumbline
