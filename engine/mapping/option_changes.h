// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.h"
#include "engine/mapping/mapper_options.h"

namespace plumbline {

/// What differs, as one line that people read and ApplyOptionChanges takes back:
/// "alpha 2.5 -> 4; floor_prior true -> false". "" where nothing differs.
std::string DescribeOptionChanges(const MapperOptions& before, const MapperOptions& after);

/// Sets what such a line says that the options became. Errors: kCorrupt, and `options` is
/// unchanged.
Status ApplyOptionChanges(std::string_view line, MapperOptions& options);

}  // namespace plumbline
