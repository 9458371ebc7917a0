// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/dataset/sequence.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/sources/folder_source.h"
#include "engine/vio/landmark_loops.h"
#include "engine/vio/own_pose_report.h"
#include "engine/vio/own_poses.h"

namespace plumbline {

/// The poses of a filter: all of them, or those that it has found so far, on a thread of its own.
/// Of those that it finds, tracks are kept of the last kTracksKept images only: whoever records
/// them takes them long before, and a recording may go on for hours. Functions are safe to call
/// from any thread.
class OwnPoseStore {
 public:
  static constexpr std::size_t kTracksKept = 2400;  ///< Two minutes of 20 Hz, some 20 MB.

  explicit OwnPoseStore(std::shared_ptr<const OwnPoses> all) : all_(std::move(all)) {}
  explicit OwnPoseStore(std::unique_ptr<OwnPoseFeed> feed);

  ~OwnPoseStore();

  /// Waits until all images up to this one have been looked at; a few more are, meanwhile.
  void Advance(int frame, const std::stop_token& stop);

  /// What is known of a frame; nothing of one that was not looked at.
  struct Known {
    std::optional<PoseEstimate> pose;  ///< Where a mapper may use it.
    std::string waits_for;             ///< Why there is none.
    std::optional<FloorReport> floor;
    std::vector<Eigen::Vector3f> points_in_world;
  };
  std::optional<Known> At(int frame) const;
  /// Where the past was corrected, by rising epoch, from the given one on.
  std::vector<PastCorrection> Corrections(std::size_t from) const;
  std::optional<FloorReport> last_floor() const;
  /// Images looked at.
  int known() const;
  /// As known now; of poses that are all known the poses themselves.
  std::shared_ptr<const OwnPoses> Copy() const;
  bool grows() const { return feed_ != nullptr; }

  /// What was found after so many images and corrections.
  struct Growth {
    OwnPoses poses;  ///< Of these alone; with the loops of all.
    int images = 0;  ///< Looked at in all.
    bool ended = false;
  };
  /// @param most_images, most_corrections  Not more of them.
  Growth Since(std::size_t image, std::size_t correction, std::size_t most_images,
               std::size_t most_corrections) const;

 private:
  const OwnPoses& poses() const { return all_ != nullptr ? *all_ : found_; }

  std::shared_ptr<const OwnPoses> all_;  ///< Null while they grow.
  std::unique_ptr<OwnPoseFeed> feed_;
  void Follow(const std::stop_token& stop);

  mutable std::mutex mutex_;  ///< Of what follows.
  std::condition_variable_any changed_;
  int wanted_ = 0;  ///< Images from this one on may wait.
  bool ended_ = false;
  OwnPoses found_;
  std::jthread thread_;  ///< Last: stops before what it uses goes.
};

/// A sequence with the poses, the gravity and the floor that the visual-inertial filter found in it
/// in place of its own. `world` is the filter's: z up, from where it began.
std::shared_ptr<const Sequence> WithOwnPoses(std::shared_ptr<const Sequence> given,
                                             std::shared_ptr<const OwnPoses> poses);
/// The same while the filter finds them: OwnPoseSource has it look at each image as it comes.
std::shared_ptr<const Sequence> WithOwnPoses(std::shared_ptr<const Sequence> given,
                                             std::unique_ptr<OwnPoseFeed> feed);

/// What WithOwnPoses was given, or what is known by now; null for any other sequence.
std::shared_ptr<const OwnPoses> OwnPosesOf(const Sequence& sequence);
/// Null for any other sequence.
std::shared_ptr<OwnPoseStore> OwnPoseStoreOf(const Sequence& sequence);
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
  std::shared_ptr<OwnPoseStore> poses_;
  FolderSource folder_;
  /// Puts what frame `frame` corrects of the past into `held_`.
  void TellCorrections(int frame);
  void TellPoints(int frame);

  int next_ = 0;  ///< The frame that Next comes to.
  std::size_t told_corrections_ = 0;
  std::optional<FloorReport> told_;  ///< The last floor that Next gave.
  std::deque<Packet> held_;          ///< Come next, in this order.
};

}  // namespace plumbline
