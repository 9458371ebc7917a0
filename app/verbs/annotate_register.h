// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// By what a sequence is registered to a scan; one of them.
struct RegisterArguments {
  std::string pairs, points, run;
};
void AddRegisterOptions(CLI::App& command, RegisterArguments& arguments);

/// `annotate register`.
Status RegisterSequence(const std::string& project, const RegisterArguments& arguments,
                        const std::string& json_file);

}  // namespace plumbline
