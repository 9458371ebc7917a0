// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where the file ends in .bag and begins as a bag of ROS 1 does.
Likeness ProbeRosBag(const std::filesystem::path& path);

/// Opens a ROS 1 bag without unpacking it. One topic is followed of each kind:
/// - images: of the topics of sensor_msgs/Image and CompressedImage without "depth" in their name
///   the one with the most messages, of equal ones the first by name (/cam0 before /cam1);
/// - depth: of those with "depth" the one of most messages, joined to images within 20 ms;
/// - the camera: sensor_msgs/CameraInfo beside the images' topic;
/// - the IMU: sensor_msgs/Imu, that of most messages;
/// - poses: /tf and /tf_static from the topmost frame above the images' frame down to it, which
/// must
///   be an optical one (z forward). By REP 103 that world is z up. Where nothing between them moves
///   there are no poses. `body_from_cam` where the two sensors are rigidly joined by TF.
///
/// What the bag lacks, or another choice, stands in NAME.bag.json beside it: {"image_topic",
/// "depth_topic", "imu_topic", "world_frame", "camera_frame", "camera": as camera.json, "imu": as
/// imu.json}. Stamps are those of the messages' headers, those of the recording where they are 0.
/// Errors: those of BagFile; kInvalidInput without images or a camera.
Result<std::shared_ptr<const Sequence>> OpenRosBag(const std::filesystem::path& file,
                                                   const SequenceOptions& options = {});

}  // namespace plumbline
