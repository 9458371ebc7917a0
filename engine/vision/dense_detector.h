// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/base/result.h"
#include "engine/vision/detector.h"
#include "engine/vision/network.h"

namespace plumbline {

/// A detector that scores every cell of a grid. It is run once on a grey image to see that its
/// outputs are what the sidecar says. Errors: kInvalidInput, kCorrupt, kUnsupported.
Result<std::unique_ptr<Detector>> CreateDenseDetector(Network network,
                                                      const DetectorOptions& options);

}  // namespace plumbline
