// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/timer.h"
#include "engine/dataset/sequence.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/sources/folder_source.h"
#include "engine/vio/landmark_loops.h"
#include "engine/vio/own_pose_report.h"
#include "engine/vio/own_poses.h"

namespace plumbline {

/// The poses of a filter: all of them, or those that it has found so far, on a thread of its own.
/// A recording may go on for hours: of those that it finds, tracks are kept of the last kTracksKept
/// images, all else of the last kReportsKept, and of older ones the pose alone; where loops moved
/// the past is kept of the last kCorrectionsKept. Functions are safe to call from any thread.
class OwnPoseStore {
 public:
  static constexpr std::size_t kTracksKept = 2'400;    ///< Two minutes of 20 Hz, some 20 MB.
  static constexpr std::size_t kReportsKept = 24'000;  ///< 20 minutes of 20 Hz, some 40 MB.
  static constexpr std::size_t kCorrectionsKept = 16;

  explicit OwnPoseStore(std::shared_ptr<const OwnPoses> all);
  /// @param first_image, first_correction  Of the feed; those before are never known.
  explicit OwnPoseStore(std::unique_ptr<OwnPoseFeed> feed, std::size_t first_image = 0,
                        std::size_t first_correction = 0);

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
  /// The image at which a correction of the past became known, by rising epoch; nothing where there
  /// is none of that number.
  std::optional<int> ImageOfCorrection(std::size_t number) const;
  /// What it made of the poses before that a mapper may use; nothing where that was let go of.
  std::vector<PoseEstimate> CorrectedPast(std::size_t number) const;
  std::optional<FloorReport> last_floor() const;
  /// Images looked at.
  int known() const;
  /// As known now; of poses that are all known the poses themselves.
  std::shared_ptr<const OwnPoses> Copy() const;
  bool grows() const { return feed_ != nullptr; }

  /// What was found after so many images and corrections.
  /// @param most_images, most_corrections  Not more of them.
  OwnPoseGrowth Since(std::size_t image, std::size_t correction, std::size_t most_images = kNoLimit,
                      std::size_t most_corrections = kNoLimit) const;

 private:
  static constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

  /// What is kept of an image of long ago.
  struct OldPose {
    std::int64_t stamp_ns = 0;
    bool ready = false;
    bool has_pose = false;
    Eigen::Matrix<double, 3, 4> world_from_cam;
    Eigen::Vector3d body_in_world;
    Eigen::Matrix<double, 21, 1> cam_covariance;  ///< Its lower triangle, row by row.
  };
  static OldPose ShortOf(const OwnPoseReport& report);
  static OwnPoseReport ReportOf(const OldPose& old);

  void Follow(const std::stop_token& stop);
  // Under `mutex_`:
  std::size_t end() const {
    return all_ != nullptr ? all_->frames.size() : first_image_ + old_.size() + recent_.size();
  }
  int known_images() const { return static_cast<int>(end()); }
  void Keep(OwnPoseReport report, std::vector<PastCorrection> corrections);
  /// Of an image that is known.
  template <typename Use>
  auto WithReport(std::size_t image, Use use) const;
  int EpochAt(int image) const;
  std::span<const PastCorrection> corrections() const;
  std::optional<PoseEstimate> EstimateOf(const OwnPoseReport& report, int frame) const;

  std::shared_ptr<const OwnPoses> all_;  ///< Null while they grow.
  std::unique_ptr<OwnPoseFeed> feed_;
  std::size_t first_image_ = 0, first_correction_ = 0;

  mutable std::mutex mutex_;  ///< Of what follows.
  std::condition_variable_any changed_;
  std::size_t wanted_ = 0;  ///< Images from this one on may wait.
  bool ended_ = false;
  std::deque<OldPose> old_;           ///< From `first_image_` on ...
  std::deque<OwnPoseReport> recent_;  ///< ... and those after them.
  std::vector<PastCorrection> corrections_;
  LoopReport loops_;
  std::jthread thread_;  ///< Last: stops before what it uses goes.
};

/// What was taken of poses that grow, for whoever keeps them: each image and correction once.
class OwnPosesTaken {
 public:
  OwnPosesTaken() = default;
  /// @param images, corrections  That are kept already.
  OwnPosesTaken(std::size_t images, std::size_t corrections)
      : images_(images), corrections_(corrections) {}

  /// What has become known since; all of it.
  std::shared_ptr<const OwnPoseGrowth> Rest(const OwnPoseStore& store);
  /// The same about once a second, else null.
  std::shared_ptr<const OwnPoseGrowth> NowAndThen(const OwnPoseStore& store);

 private:
  std::size_t images_ = 0, corrections_ = 0;
  std::optional<Stopwatch> since_taken_;
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
