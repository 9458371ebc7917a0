// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stop_token>
#include <vector>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/dataset/imu_file.h"
#include "engine/dataset/sequence.h"
#include "engine/vio/own_pose_options.h"
#include "engine/vio/own_pose_report.h"
#include "engine/vio/vio_run.h"

namespace plumbline {

/// What the estimator needs of a sequence besides images. `imu` must outlive it. Errors:
/// kInvalidInput, naming what the sequence lacks: readings of an IMU, or where the camera sits on
/// the body.
Result<VioInput> VioInputOf(const Sequence& sequence, const ImuRecording& imu);

/// Poses that somebody finds, image by image. Single-threaded.
class OwnPoseFeed {
 public:
  virtual ~OwnPoseFeed() = default;
  /// Waits for what is said of the next image; false where there is none, or once `stop` is
  /// requested.
  virtual bool Next(const std::stop_token& stop) = 0;
  /// What is said of the image that Next came to; to be taken once.
  virtual OwnPoseReport TakeReport() = 0;
  /// Corrections that came since they were taken last, perhaps of images that Next has yet to come
  /// to.
  virtual std::vector<PastCorrection> TakeCorrections() = 0;
  /// Places known again so far.
  virtual const LoopReport& loops() const = 0;
};

/// EstimateOwnPoses, image by image. Single-threaded.
class OwnPoseEstimator : public OwnPoseFeed {
 public:
  /// @param sequence  May be one that grows (GrowingRecordingOf).
  /// @param end_frame  Images from this one on are not looked at.
  /// Errors: as of VioInputOf; kNotFound for a sequence without images.
  static Result<std::unique_ptr<OwnPoseEstimator>> Create(std::shared_ptr<const Sequence> sequence,
                                                          int end_frame,
                                                          const OwnPoseOptions& options);
  ~OwnPoseEstimator() override;

  /// Looks at the next image, of a recording that grows once it and the readings of the IMU up to
  /// it have come; false where there is none, or once `stop` is requested.
  bool Next(const std::stop_token& stop = {}) override;
  OwnPoseReport TakeReport() override;
  std::vector<PastCorrection> TakeCorrections() override;
  const LoopReport& loops() const override;
  /// First image that was not looked at.
  int next() const;
  /// One past the last image that will be; of a recording that grows, that has come.
  int end() const;
  /// After the last image, of which no report was taken: corrects the whole trajectory where that
  /// is asked for. Errors: kDegenerate where no image got a pose that a mapper may use.
  Result<OwnPoses> Finish();

 private:
  struct Impl;
  explicit OwnPoseEstimator(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Poses of a sequence from its images and IMU alone; its own poses, gravity and floor are not
/// looked at. Causal, unless loops correct the whole trajectory (`options.loops`,
/// OwnPoses::causal): what is said of an image does not depend on later ones. Deterministic; about
/// 10 ms an image.
/// @param end_frame  Images from this one on are not looked at.
/// Errors: as of VioInputOf; kNotFound for a sequence without images; kDegenerate where no image
/// gets a pose that a mapper may use; kCancelled.
Result<OwnPoses> EstimateOwnPoses(std::shared_ptr<const Sequence> sequence, int end_frame,
                                  const OwnPoseOptions& options, const WorkContext& work);

}  // namespace plumbline
