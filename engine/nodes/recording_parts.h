// SPDX-License-Identifier: Apache-2.0
#pragma once

// What whoever writes the run of a graph does besides: the recorder, and who keeps a copy.

#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/timer.h"
#include "engine/mapping/map_report.h"
#include "engine/nodes/node_link.h"
#include "engine/pipeline/own_pose_sequence.h"
#include "engine/transport/plumbline.pb.h"

namespace plumbline {

/// Sets of particles that an object has kept since the frame before are one set again, as the
/// mapper has them: the run file stores them once.
class ParticleSharing {
 public:
  /// @param report  Made of `message`; its particles are replaced by those of the frame before.
  void Share(const wire::Report& message, FrameReport& report);

 private:
  struct Kept {
    std::string bytes;
    std::shared_ptr<const std::vector<Particle>> particles;
  };
  std::map<int, Kept> kept_;  ///< By object, of the last frame.
};

/// The poses that another node finds for a run: all at once, or, of a live run, as they grow.
class RunPoses {
 public:
  /// Of a run whose poses nobody finds: none, ever.
  RunPoses() = default;
  /// Of a run that is not live: waits for them. Errors: kCancelled; what the node refused.
  static Result<RunPoses> Ask(NodeClient& vio, const std::stop_token& stop);
  /// Of a live run. @param images, corrections  That the run file has already.
  static RunPoses Follow(NodeClient& vio, std::size_t images, std::size_t corrections);

  /// Of a run that is not live, all; else null.
  const OwnPoses* all() const { return all_.get(); }
  /// Of a live run, what has become known since; about once a second, else null.
  std::shared_ptr<const OwnPoseGrowth> GrownUpTo(int frame, const std::stop_token& stop);
  /// Of a live run at its end, the rest up to that frame; else null.
  std::shared_ptr<const OwnPoseGrowth> RestUpTo(int frame, const std::stop_token& stop);

 private:
  std::shared_ptr<const OwnPoses> all_;
  std::unique_ptr<OwnPoseStore> growing_;
  OwnPosesTaken taken_;
};

}  // namespace plumbline
