// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/window/inspect/inspect_workspace.h"
#include "engine/runtime/mapping_source.h"
#include "engine/runtime/run_source.h"

namespace plumbline {

/// How the window opens a path: run files by their ending, kDemoPath, everything else as a
/// sequence. A run that was recorded is not replaced: the next sequence that is opened is recorded
/// beside it, as RUN-2.plb and so on. A network without a sidecar gets the one that it looks like.
decltype(InspectOptions::opener) SourceOpener(const MappingChoice& live, const RunChoice& run);

}  // namespace plumbline
