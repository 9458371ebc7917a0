// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "ui/framework/option_name.h"

namespace plumbline {

/// Plain names of the mapper's options, by group, in the order in which forms show them.
std::span<const OptionName> MapperOptionNames();

}  // namespace plumbline
