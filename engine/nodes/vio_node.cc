// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "engine/base/timer.h"
#include "engine/nodes/our_nodes.h"
#include "engine/nodes/own_pose_message.h"
#include "engine/nodes/remote_sequence.h"
#include "engine/vio/own_poses.h"

namespace plumbline {
namespace {

/// As EstimateOwnPoses does it, telling how far it is.
Result<OwnPoses> FindPoses(const NodeSetup& setup, NodeLink& link) {
  const RunRecipe& recipe = *setup.plan.recipe;
  const std::stop_token& stop = setup.work.stop;
  link.SetState("waiting for '" + setup.node.images + "'");
  const Result<NodeClient*> player = link.Ask(setup.node.images);
  if (!player.ok()) return player.error();
  FramesAhead ahead = FramesOf(recipe);
  ahead.begin = 0;  // the filter follows all images, whichever are mapped
  ahead.step = 1;
  const auto sequence = RemoteSequence::OpenForFilter(**player, ahead, stop);
  if (!sequence.ok()) return sequence.error();
  const int end = std::min(ahead.end, (*sequence)->num_frames());
  const auto estimator = OwnPoseEstimator::Create(*sequence, end, recipe.own_poses);
  if (!estimator.ok()) return estimator.error();
  StreamMeter& found = link.AddStream("poses");
  for (Stopwatch watch; !stop.stop_requested() && (*estimator)->Next(); watch = Stopwatch()) {
    found.Count(watch.Milliseconds());
    link.SetState("followed " + std::to_string((*estimator)->next()) + " of " +
                  std::to_string(end) + " images");
  }
  if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  return (*estimator)->Finish();
}

}  // namespace

Status RunVioNode(const NodeSetup& setup) {
  const Result<std::unique_ptr<NodeLink>> link = NodeLink::Open(setup);
  if (!link.ok()) return link.error();
  const Result<OwnPoses> poses = FindPoses(setup, **link);
  if (!poses.ok())
    return poses.error().code == ErrorCode::kCancelled ? Status() : Status(poses.error());
  (*link)->SetState("found poses of " + std::to_string(poses->frames.size()) + " images, closed " +
                    std::to_string(poses->loops.believed()) + " loops");
  (*link)->Serve(setup.work.stop, [&](const wire::Request& request) -> Result<wire::Reply> {
    if (!request.has_own_poses()) return DoesNotAnswer(request, setup.node);
    wire::Reply reply;
    *reply.mutable_own_poses() = OwnPosesToWire(*poses, request.own_poses().from());
    return reply;
  });
  return {};
}

}  // namespace plumbline
