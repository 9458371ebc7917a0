// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.h"
#include "engine/mapping/mapper_options.h"

namespace plumbline {

/// The options that differ, as JSON: {"alpha": [2.5, 4.0]}, before and after. "" where none does.
std::string OptionChanges(const MapperOptions& before, const MapperOptions& after);

/// Sets what such changes say that the options became. Errors: kCorrupt, and `options` is
/// unchanged.
Status ApplyOptionChanges(std::string_view changes, MapperOptions& options);

/// For people: "alpha 2.5 -> 4.0; floor_prior true -> false". "" of what OptionChanges did not
/// make.
std::string DescribeOptionChanges(std::string_view changes);

/// Run files of format 1 kept only the line for people. Errors: kCorrupt.
Result<std::string> OptionChangesFromFormat1(std::string_view line);

}  // namespace plumbline
