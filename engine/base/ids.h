// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <functional>

namespace plumbline {

/// An integer that does not mix with other kinds of integers.
template <typename Tag>
struct StrongId {
  std::int32_t value = -1;
  auto operator<=>(const StrongId&) const = default;
};

using ObjectId =
    StrongId<struct ObjectIdTag>;  ///< An object of the map; counted from 1 in order of birth.
using ModelId =
    StrongId<struct ModelIdTag>;  ///< Index of a model in its database: the shape label.

}  // namespace plumbline

template <typename Tag>
struct std::hash<plumbline::StrongId<Tag>> {
  std::size_t operator()(plumbline::StrongId<Tag> id) const noexcept {
    return std::hash<std::int32_t>()(id.value);
  }
};
