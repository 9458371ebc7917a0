// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "engine/runtime/mapping_process.h"
#include "engine/runtime/mapping_source.h"
#include "engine/runtime/run_source.h"

namespace plumbline {

/// How the window opens a path: run files by their ending, kDemoPath, everything else as a
/// sequence.
std::function<MappingProcess::OpenSource(const std::string& path, const std::string& models)>
SourceOpener(const MappingChoice& live, const RunChoice& run);

}  // namespace plumbline
