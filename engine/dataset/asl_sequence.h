// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there is mav0/cam0/data.csv, or cam0/data.csv.
Likeness ProbeAslSequence(const std::filesystem::path& path);

/// Opens a folder in the ASL layout of EuRoC and TUM-VI, with its first camera: the images that
/// cam0/data.csv lists, cam0/sensor.yaml, imu0 where there is one, and the poses of
/// state_groundtruth_estimate0 or mocap0 within half a period. `world` is z up. Grey images are
/// read as colour. Errors: kNotFound, kCorrupt, kInvalidInput, kUnsupported; one sentence that
/// names the file.
Result<std::shared_ptr<const Sequence>> OpenAslSequence(const std::filesystem::path& folder,
                                                        const SequenceOptions& options = {});

/// Writes that layout: images as recorded (undistorted where the lens is of another model), the
/// IMU, and the poses of the body as mocap0, in a world turned z up. Without `body_from_cam` the
/// body is the camera. There is no place for depth and objects. Errors: kIo, kCancelled,
/// kInvalidInput.
Result<WrittenSequence> WriteAslSequence(const Sequence& sequence,
                                         const std::filesystem::path& folder,
                                         const WriteOptions& options, const WorkContext& context);

}  // namespace plumbline
