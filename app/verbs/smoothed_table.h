// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/base/result.h"

namespace plumbline {

class ModelDatabase;
struct SmoothedMap;

/// Writes the objects of a smoothed map to standard output, a row each.
void PrintSmoothed(const SmoothedMap& map, const ModelDatabase& database);

/// Why a run has no smoothed map, and what is left: the run.
Error NotSmoothed(const Error& error, const std::string& run);

}  // namespace plumbline
