// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>
#include <stop_token>

#include "engine/nodes/requests_ahead.h"
#include "engine/vision/detector.h"
#include "engine/vision/edge_detector.h"

namespace plumbline {

/// The mapper asked another process for scores, and is stopped while it waits for them. Caught by
/// the node: the frame is as if it had not been begun.
class StoppedWaiting : public std::runtime_error {
 public:
  StoppedWaiting() : std::runtime_error("stopped while waiting for another process") {}
};

/// Edges that another process finds. Of a frame only its number is sent: the process asks the
/// player for the image itself. @param node  Outlives it.
std::unique_ptr<EdgeDetector> MakeRemoteEdgeDetector(NodeClient& node, const FramesAhead& ahead,
                                                     std::stop_token stop);

/// Objects, likewise. ScoreBoxes throws StoppedWaiting once `stop` is requested.
std::unique_ptr<Detector> MakeRemoteDetector(NodeClient& node, const FramesAhead& ahead,
                                             std::stop_token stop);

}  // namespace plumbline
