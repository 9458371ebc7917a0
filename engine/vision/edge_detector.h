// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "engine/base/result.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// Finds edges: thinned, calibrated probability, and the direction of the normal. Not safe to use
/// from several threads at once.
class EdgeDetector {
 public:
  virtual ~EdgeDetector() = default;
  virtual Result<EdgeMap> Detect(const Frame& frame) = 0;
};

struct EdgeOptions {
  /// Off: a network's raw scores in place of probabilities, to measure a calibration with.
  bool calibrate = true;
  /// Off: a network runs, whatever NetworkCache knows; to measure its time with.
  bool cache = true;
};

/// `builtin` (our network; `builtin-half`: one with half the channels), `gradient` (multi-scale,
/// oriented), `dataset` (the sequence's edges), or the path of an ONNX edge network with its
/// sidecar. Errors: kNotFound, kCorrupt, kInvalidInput, kUnsupported.
Result<std::unique_ptr<EdgeDetector>> CreateEdgeDetector(std::string_view choice,
                                                         std::shared_ptr<const Sequence> sequence,
                                                         const EdgeOptions& options = {});

}  // namespace plumbline
