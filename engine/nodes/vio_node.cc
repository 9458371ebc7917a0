// SPDX-License-Identifier: Apache-2.0
#include <thread>

#include "engine/base/timer.h"
#include "engine/nodes/our_nodes.h"
#include "engine/nodes/own_pose_message.h"
#include "engine/nodes/remote_sequence.h"
#include "engine/vio/own_poses.h"

namespace plumbline {
namespace {

Result<std::unique_ptr<OwnPoseEstimator>> OpenEstimator(const NodeSetup& setup, NodeLink& link) {
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
  return OwnPoseEstimator::Create(*sequence, ahead.end, recipe.own_poses);
}

/// As EstimateOwnPoses does it, telling how far it is.
Result<OwnPoses> FindPoses(const NodeSetup& setup, NodeLink& link) {
  const std::stop_token& stop = setup.work.stop;
  const auto estimator = OpenEstimator(setup, link);
  if (!estimator.ok()) return estimator.error();
  const int end = (*estimator)->end();
  StreamMeter& found = link.AddStream("poses");
  for (Stopwatch watch; !stop.stop_requested() && (*estimator)->Next(); watch = Stopwatch()) {
    found.Count(watch.Milliseconds());
    link.SetState("followed " + std::to_string((*estimator)->next()) + " of " +
                  std::to_string(end) + " images");
  }
  if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  return (*estimator)->Finish();
}

/// Finds poses while it is asked for them: of a live run nobody waits for the last one.
Status FindWhileServing(const NodeSetup& setup, NodeLink& link) {
  const std::stop_token& stop = setup.work.stop;
  Result<std::unique_ptr<OwnPoseEstimator>> estimator = OpenEstimator(setup, link);
  if (!estimator.ok()) return estimator.error();
  OwnPoseStore store(std::move(estimator).value());
  StreamMeter& found = link.AddStream("poses");
  const std::jthread following([&](const std::stop_token& end) {
    for (int image = 0; !end.stop_requested(); ++image) {
      const Stopwatch watch;
      store.Advance(image, end);
      if (store.known() <= image) break;
      found.Count(watch.Milliseconds());
      link.SetState("followed " + std::to_string(store.known()) + " images");
    }
  });
  link.Serve(stop, [&](const wire::Request& request) -> Result<wire::Reply> {
    if (!request.has_own_poses() || !request.own_poses().by_now())
      return DoesNotAnswer(request, setup.node);
    wire::Reply reply;
    *reply.mutable_own_poses() = OwnPosesByNow(store, request.own_poses());
    return reply;
  });
  return {};
}

}  // namespace

Status RunVioNode(const NodeSetup& setup) {
  const Result<std::unique_ptr<NodeLink>> link = NodeLink::Open(setup);
  if (!link.ok()) return link.error();
  if (setup.plan.recipe->live_speed) {
    Status status = FindWhileServing(setup, **link);
    return !status.ok() && status.error().code == ErrorCode::kCancelled ? Status() : status;
  }
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
