// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a visual-inertial filter in another process is given besides images, and what it found.

#include <limits>
#include <memory>
#include <stop_token>
#include <vector>

#include "engine/base/result.h"
#include "engine/dataset/growing_recording.h"
#include "engine/dataset/imu_file.h"
#include "engine/pipeline/own_pose_sequence.h"
#include "engine/sensor/calibration.h"
#include "engine/transport/node_client.h"
#include "engine/transport/plumbline.pb.h"
#include "engine/vio/own_pose_report.h"

namespace plumbline {

/// The calibration of the first camera and of the IMU, and readings from the `from`th on, as many
/// as fit a message.
wire::Imu ImuToWire(const Calibration& calibration, const ImuRecording& imu, int from);
/// Adds the readings of a message to those before, and takes its calibration.
/// @return whether these are all. Errors: kCorrupt.
Result<bool> AddImuFromWire(const wire::Imu& message, Calibration& calibration,
                            std::vector<ImuSample>& samples);

/// Images from the `from`th on, as many as fit a message.
wire::OwnPoses OwnPosesToWire(const OwnPoses& poses, int from);
/// Adds the images of a message to those before. @return whether these are all. Errors: kCorrupt.
Result<bool> AddOwnPosesFromWire(const wire::OwnPoses& message, OwnPoses& poses);

/// As the number of readings that are known: none are wanted.
inline constexpr int kEveryReading = std::numeric_limits<int>::max();

/// What a player has after so many frames and readings.
/// @param growing  As of `sequence`; null: it is recorded by now, who asks began before.
/// Errors: of the readings.
Result<wire::Growth> GrowthToWire(const Sequence& sequence, const GrowingRecording* growing,
                                  const wire::GrowthRequest& known);
/// Adds its readings to those before. Errors: kCorrupt.
Status AddGrowthFromWire(const wire::Growth& growth, std::vector<ImuSample>& samples);

/// What a filter has found by now after what is known, as much as fits a message.
wire::OwnPoses OwnPosesByNow(const OwnPoseStore& store, const wire::OwnPosesRequest& known);
/// Adds them to what was not taken yet. @param images  That were known before. @return whether more
/// may come. Errors: kCorrupt.
Result<bool> AddOwnPosesByNow(const wire::OwnPoses& message, int images, OwnPoses& poses);

/// Poses of a filter in another process, as it finds them.
/// @param vio  Outlives it. @param images, corrections  That are known already.
std::unique_ptr<OwnPoseFeed> MakeRemoteOwnPoses(NodeClient& vio, std::size_t images = 0,
                                                std::size_t corrections = 0);

/// Waits until the filter has seen all images. Errors: what it refuses; kCorrupt; kCancelled.
Result<std::shared_ptr<const OwnPoses>> AskForOwnPoses(NodeClient& vio,
                                                       const std::stop_token& stop);

}  // namespace plumbline
