// SPDX-License-Identifier: Apache-2.0
#include "engine/nodes/recording_parts.h"

#include <algorithm>
#include <utility>

#include "engine/nodes/own_pose_message.h"
#include "engine/nodes/remote_sequence.h"

namespace plumbline {

void ParticleSharing::Share(const wire::Report& message, FrameReport& report) {
  std::map<int, Kept> now;
  for (int i = 0; i < message.objects_size(); ++i) {
    const std::string& bytes = message.objects(i).particles();
    if (bytes.empty()) continue;
    auto& particles = report.objects[static_cast<std::size_t>(i)].particles;
    const auto before = kept_.find(message.objects(i).id());
    if (before != kept_.end() && before->second.bytes == bytes)
      particles = before->second.particles;
    now[message.objects(i).id()] = {bytes, particles};
  }
  kept_ = std::move(now);
}

Result<RunPoses> RunPoses::Ask(NodeClient& vio, const std::stop_token& stop) {
  auto found = AskForOwnPoses(vio, stop);
  if (!found.ok()) return found.error();
  RunPoses poses;
  poses.all_ = std::move(found).value();
  return poses;
}

RunPoses RunPoses::Follow(NodeClient& vio, std::size_t images, std::size_t corrections) {
  RunPoses poses;
  poses.growing_ = std::make_unique<OwnPoseStore>(MakeRemoteOwnPoses(vio, images, corrections),
                                                  images, corrections);
  poses.taken_ = OwnPosesTaken(images, corrections);
  return poses;
}

std::shared_ptr<const OwnPoseGrowth> RunPoses::GrownUpTo(int frame, const std::stop_token& stop) {
  if (growing_ == nullptr) return nullptr;
  growing_->Advance(frame, stop);
  return taken_.NowAndThen(*growing_);
}

std::shared_ptr<const OwnPoseGrowth> RunPoses::RestUpTo(int frame, const std::stop_token& stop) {
  if (growing_ == nullptr) return nullptr;
  growing_->Advance(frame, stop);
  return taken_.Rest(*growing_);
}

}  // namespace plumbline
