// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "engine/base/result.h"
#include "engine/vision/edge_detector.h"
#include "engine/vision/network.h"

namespace plumbline {

/// Edges of a network: its soft map is thinned, and its scores become probabilities by the
/// calibration of the sidecar (docs/algorithms/edges.md). Errors: kInvalidInput (finds no edges,
/// output not as stated), kCorrupt.
Result<std::unique_ptr<EdgeDetector>> CreateEdgeNetwork(Network network,
                                                        const EdgeOptions& options);

/// The one that is built into the program; `half`: on images of half the size, for live work.
Result<std::unique_ptr<EdgeDetector>> BuiltinEdgeNetwork(bool half, const EdgeOptions& options);
/// Content hash of its weights and sidecar.
std::string HashOfBuiltinEdges(bool half);

}  // namespace plumbline
