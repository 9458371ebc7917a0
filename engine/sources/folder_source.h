// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "engine/dataset/growing_recording.h"
#include "engine/dataset/imu_file.h"
#include "engine/sources/frame_source.h"

namespace plumbline {

/// The packets of a sequence on disk. Its poses are given: their covariance is zero, their id is
/// the number of the frame.
class FolderSource : public RecordedSource {
 public:
  /// @param with_imu  Whether Next gives IMU samples; imu.csv is not read without.
  explicit FolderSource(std::shared_ptr<const Sequence> sequence, bool with_imu = true);
  /// Of a sequence that grows: Next waits for frames that have not come yet, and gives no IMU
  /// samples. @param growing  As of the sequence; null: it does not grow.
  FolderSource(std::shared_ptr<const Sequence> sequence, const GrowingRecording* growing)
      : sequence_(std::move(sequence)), growing_(growing), with_imu_(false) {}

  const Calibration& calibration() const override;
  /// Errors: also kCorrupt for imu.csv, which is read with the first packet.
  Result<std::optional<Packet>> Next(const std::stop_token& stop) override;
  int num_frames() const override;
  FramePacket Frame(int frame) const override;
  std::optional<PoseEstimate> Pose(int frame) const override;
  void Seek(int frame) override;

 private:
  /// Puts all that comes up to the next frame into `ready_`.
  void Refill(const std::stop_token& stop);

  std::shared_ptr<const Sequence> sequence_;
  const GrowingRecording* growing_ = nullptr;
  bool with_imu_;
  std::optional<ImuRecording> imu_;
  std::deque<Packet> ready_;
  int frame_ = 0;           ///< The next one.
  std::size_t sample_ = 0;  ///< The next one.
  bool told_world_ = false;
  bool ended_ = false;
};

/// @param poses  The trajectory that the sequence was opened with; empty: its own poses.
/// Errors: kInvalidInput where no frame of the sequence has a pose: a sentence that names the
/// remedy.
Status CheckHasPoses(const Sequence& sequence, const std::filesystem::path& poses = {});

}  // namespace plumbline
