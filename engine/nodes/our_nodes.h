// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/result.h"
#include "engine/nodes/node_link.h"
#include "engine/nodes/requests_ahead.h"

namespace plumbline {

// The modules as processes. Each runs until its work is asked to stop, and then ends without an
// error; the recorder ends without one when the run has ended, and with kCancelled where it was
// stopped before. Errors: what it cannot begin with, in one sentence. docs/processes.md says what
// each answers.

/// Plays the sequence of the recipe: stamps, poses, images, edges and proposals that were recorded.
Status RunPlayerNode(const NodeSetup& setup);
/// Finds edges as the recipe says.
Status RunEdgesNode(const NodeSetup& setup);
/// Finds objects, and scores boxes, as the recipe says.
Status RunDetectorNode(const NodeSetup& setup);
/// Finds poses from images and the IMU as the recipe says, of all its frames before it answers.
Status RunVioNode(const NodeSetup& setup);
/// Records a camera, or an IMU, into the folder of the recipe's sequence, which BeginRecording
/// made; goes on with what is there. Ends without an error, too, when nothing more can come.
Status RunCameraNode(const NodeSetup& setup);
Status RunImuNode(const NodeSetup& setup);
/// Maps, from where the recorder stands.
Status RunMapperNode(const NodeSetup& setup);
/// Writes the run file.
Status RunRecorderNode(const NodeSetup& setup);

Status RunNode(const NodeSetup& setup);

/// In the graph's folder once its recorder has begun the run file.
inline constexpr const char* kRunBegun = "recording";

/// Edges as an answer.
Result<wire::Reply> EdgesReply(const wire::Request& request, SendablePixels& probability,
                               SendablePixels& angle);

/// The frames that the recipe selects, as far as it says.
FramesAhead FramesOf(const RunRecipe& recipe);

}  // namespace plumbline
