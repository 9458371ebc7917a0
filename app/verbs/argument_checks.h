// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace plumbline {

/// A whole number from 0, in digits.
CLI::Validator IsSeed();

}  // namespace plumbline
