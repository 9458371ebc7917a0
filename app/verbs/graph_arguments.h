// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/base/result.h"
#include "engine/nodes/graph_plan.h"

namespace plumbline {

/// The graph that the command line names: a file, the folder that `up` told, or one that is built
/// in (`paper`). Errors: those of ReadGraph.
Result<GraphPlan> GraphNamed(const std::string& name);

}  // namespace plumbline
