// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/dataset/sequence.h"
#include "engine/nodes/requests_ahead.h"

namespace plumbline {

/// A sequence that another process plays. Stamps, poses, gravity and floor are asked for once; of
/// each frame the image, edges and proposals when they are read, images ahead. Raw images and the
/// IMU are played only to OpenForFilter, depth is not. A read that is stopped gives kCancelled.
///
/// One that is being recorded (GrowingRecordingOf) is asked for its growth every few milliseconds,
/// on a thread of its own.
class RemoteSequence : public Sequence {
 public:
  /// Asks the player, waiting until it is there.
  /// @param player  Outlives this.
  /// @param ahead  Its begin, step and end of what will be read; the end is cut to the sequence's.
  /// Errors: what the player refuses; kCorrupt; kCancelled.
  static Result<std::shared_ptr<const RemoteSequence>> Open(NodeClient& player, FramesAhead ahead,
                                                            std::stop_token stop);

  /// The same with the IMU and the calibration of raw images, which are then read ahead in the
  /// place of undistorted ones. The camera is the first one.
  static Result<std::shared_ptr<const RemoteSequence>> OpenForFilter(NodeClient& player,
                                                                     FramesAhead ahead,
                                                                     std::stop_token stop);

  const std::filesystem::path& path() const override { return path_; }
  int num_frames() const override {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(frames_.size());
  }
  /// Whether there is such a frame; of a recording that grows waits for one that the player told
  /// somebody else of a moment ago.
  bool AwaitFrame(int index, const std::stop_token& stop) const;
  const PinholeCamera& camera() const override { return camera_; }
  const Calibration& calibration() const override { return calibration_; }
  double rate_hz() const override { return rate_hz_; }
  std::int64_t stamp_ns(int index) const override { return RowOf(index).stamp_ns; }
  std::optional<Eigen::Isometry3d> world_from_cam(int index) const override {
    const FrameRow row = RowOf(index);
    return row.given ? std::optional(row.given->world_from_cam) : std::nullopt;
  }
  PoseUncertainty pose_uncertainty(int index) const override {
    const FrameRow row = RowOf(index);
    return row.given ? row.given->uncertainty : PoseUncertainty();
  }
  std::optional<Eigen::Vector3d> gravity_in_world() const override { return gravity_; }
  std::optional<Eigen::Vector4d> floor_in_world() const override { return floor_; }
  double floor_std_m() const override { return floor_std_m_; }
  std::vector<FloorLevel> floor_levels() const override { return levels_; }

  Result<Frame> ReadFrame(int index) const override;
  Result<cv::Mat> ReadRawImage(int index) const override;
  Result<std::optional<cv::Mat>> ReadDepth(int) const override { return std::optional<cv::Mat>(); }
  Result<std::optional<EdgeMap>> ReadEdges(int index) const override;
  Result<std::optional<std::vector<Detection>>> ReadProposals(int index) const override;
  Result<ImuRecording> ReadImu() const override {
    const std::lock_guard lock(mutex_);
    return imu_;
  }
  bool has_images() const override { return has_images_; }
  bool has_imu() const override {
    const std::lock_guard lock(mutex_);
    return !imu_.samples.empty();
  }
  bool has_depth() const override { return false; }
  bool has_edges() const override { return has_edges_; }
  bool has_proposals() const override { return has_proposals_; }
  std::optional<std::filesystem::path> scene_file() const override { return scene_file_; }
  std::optional<std::filesystem::path> ground_truth_file() const override {
    return ground_truth_file_;
  }
  std::optional<std::filesystem::path> models_folder() const override { return models_folder_; }
  std::optional<std::filesystem::path> tracks_file() const override { return std::nullopt; }
  std::optional<std::filesystem::path> reference_file() const override { return std::nullopt; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

  /// Milliseconds since the image of a frame came here; nothing where that is long ago.
  std::optional<double> AgeMs(int frame) const;

  /// The description as a message has it. Errors: kCorrupt. For tests without a player.
  static Result<std::shared_ptr<const RemoteSequence>> FromWire(const wire::Sequence& message,
                                                                NodeClient* player,
                                                                FramesAhead ahead,
                                                                std::stop_token stop);

 protected:
  struct GivenPose {
    Eigen::Isometry3d world_from_cam;
    PoseUncertainty uncertainty;
  };
  /// Few bytes: a recording that grows may have very many, and none of them has a pose.
  struct FrameRow {
    std::int64_t stamp_ns = 0;
    std::int64_t came_ns = 0;  ///< By the steady clock, of a recording that grows.
    std::shared_ptr<const GivenPose> given;
  };

  RemoteSequence() = default;
  FrameRow RowOf(int index) const;

  mutable std::mutex mutex_;  ///< Of what follows.
  mutable std::condition_variable_any changed_;
  std::vector<FrameRow> frames_;
  mutable ImuRecording imu_;  ///< Only of OpenForFilter. Of a recording that grows the last ones.

 private:
  static Result<std::shared_ptr<RemoteSequence>> Ask(NodeClient& player, FramesAhead& ahead,
                                                     const std::stop_token& stop);
  Status Take(const wire::Sequence& message);
  void AskAhead(NodeClient& player, const FramesAhead& ahead);

  std::filesystem::path path_;
  PinholeCamera camera_;
  Calibration calibration_;
  double rate_hz_ = 30;
  std::optional<Eigen::Vector3d> gravity_;
  std::optional<Eigen::Vector4d> floor_;
  double floor_std_m_ = 0;
  std::vector<FloorLevel> levels_;
  bool has_images_ = false, has_edges_ = false, has_proposals_ = false;
  std::optional<std::filesystem::path> scene_file_, ground_truth_file_, models_folder_;
  std::vector<std::string> warnings_;
  std::stop_token stop_;
  std::unique_ptr<RequestsAhead> images_, edges_, proposals_;
  std::unique_ptr<RequestsAhead> raw_images_;  ///< Null unless OpenForFilter.
  /// Of the last frames, under `mutex_`.
  mutable std::map<int, std::chrono::steady_clock::time_point> came_;
};

/// The edges of a reply. Errors: kNotFound for shared memory that is gone; kCorrupt.
Result<EdgeMap> EdgesFromWire(const wire::Edges& edges);

wire::Request ImageRequestOf(int frame);
wire::Request RawImageRequestOf(int frame);
wire::Request EdgesRequestOf(int frame);
wire::Request ProposalsRequestOf(int frame);

}  // namespace plumbline
