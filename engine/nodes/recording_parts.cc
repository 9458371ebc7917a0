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

Result<RunPoses> RunPoses::Ask(NodeClient& vio, bool live, const std::stop_token& stop) {
  RunPoses poses;
  if (live) {
    poses.growing_ = std::make_unique<OwnPoseStore>(MakeRemoteOwnPoses(vio));
    return poses;
  }
  auto found = AskForOwnPoses(vio, stop);
  if (!found.ok()) return found.error();
  poses.all_ = std::move(found).value();
  return poses;
}

std::shared_ptr<const OwnPoses> RunPoses::GrownUpTo(int frame, const std::stop_token& stop) {
  if (growing_ == nullptr) return nullptr;
  growing_->Advance(frame, stop);
  if (since_grown_.Milliseconds() < pause_ms_) return nullptr;
  since_grown_ = Stopwatch();
  auto poses = growing_->Copy();
  pause_ms_ = std::max(1000.0, 20 * since_grown_.Milliseconds());
  return poses;
}

std::shared_ptr<const OwnPoses> RunPoses::AllUpTo(int frame, const std::stop_token& stop) {
  if (growing_ == nullptr) return nullptr;
  growing_->Advance(frame, stop);
  return growing_->Copy();
}

}  // namespace plumbline
