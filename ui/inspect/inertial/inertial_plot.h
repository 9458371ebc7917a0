// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/framework/frame_context.h"

namespace plumbline {

/// Rates, biases with their bounds, innovations with their gate and the distance from the reference
/// over all frames, in the room that is left; the frame that shows is marked.
void DrawInertialPlots(const FrameContext& context);

/// How far the camera is from the reference at a frame, trajectories aligned [m]; nothing without
/// one.
std::optional<double> DistanceFromReference(const SequenceView& sequence, int frame);

}  // namespace plumbline
