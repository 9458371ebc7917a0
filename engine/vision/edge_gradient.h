// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/vision/edge_detector.h"

namespace plumbline {

/// Edges from image gradients alone: structure tensors of brightness and colour over three scales,
/// thinned, each line pixel's probability from what the scales and its surroundings say. No
/// network. See docs/algorithms/edges.md.
std::unique_ptr<EdgeDetector> CreateGradientEdgeDetector(const EdgeOptions& options);

}  // namespace plumbline
