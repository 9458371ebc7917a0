// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "engine/dataset/sequence.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/sources/folder_source.h"
#include "engine/vio/landmark_loops.h"
#include "engine/vio/own_pose_report.h"

namespace plumbline {

/// A sequence with the poses, the gravity and the floor that the visual-inertial filter found in it
/// in place of its own. `world` is the filter's: z up, from where it began.
std::shared_ptr<const Sequence> WithOwnPoses(std::shared_ptr<const Sequence> given,
                                             std::shared_ptr<const OwnPoses> poses);

/// What WithOwnPoses was given; null for any other sequence.
std::shared_ptr<const OwnPoses> OwnPosesOf(const Sequence& sequence);
/// The sequence with its given poses: what WithOwnPoses was given, or the sequence itself.
const Sequence& GivenSequence(const Sequence& sequence);

/// What corrected the poses of a run up to a frame, from what its file keeps.
/// @param sequence  Of WithOwnPoses. @param recipe  Of the run: its frames, and how loops close.
LandmarkLoops ReplayLandmarks(const std::shared_ptr<const Sequence>& sequence,
                              const RunRecipe& recipe, int last_frame,
                              const LandmarkHistory& history);

/// The packets of WithOwnPoses: poses with their covariance, the floor when it becomes known or is
/// known better, and the points that were finished while poses could be used.
class OwnPoseSource : public RecordedSource {
 public:
  /// @param sequence  Of WithOwnPoses.
  explicit OwnPoseSource(const std::shared_ptr<const Sequence>& sequence);

  const Calibration& calibration() const override { return folder_.calibration(); }
  Result<std::optional<Packet>> Next(const std::stop_token& stop) override;
  int num_frames() const override { return folder_.num_frames(); }
  FramePacket Frame(int frame) const override { return folder_.Frame(frame); }
  std::optional<PoseEstimate> Pose(int frame) const override;
  void Seek(int frame) override;
  /// Why a frame has no pose.
  std::string WaitsFor(int frame) const;

 private:
  std::shared_ptr<const OwnPoses> poses_;
  FolderSource folder_;
  /// Puts what frame `frame` corrects of the past into `held_`.
  void TellCorrections(int frame);
  void TellPoints(int frame);

  std::optional<FloorReport> told_;  ///< The last floor that Next gave.
  std::deque<Packet> held_;          ///< Come next, in this order.
};

}  // namespace plumbline
