// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there is a rgb.txt.
Likeness ProbeTumRgbd(const std::filesystem::path& path);

/// Opens a folder of the TUM RGB-D benchmark: rows `stamp file` of rgb.txt and depth.txt (16 bits,
/// 5000 to the metre, 0 = none), and groundtruth.txt (TUM, world_from_cam, `world` z up). An image
/// takes the depth within 20 ms and the pose between its two neighbours. The camera is that of
/// calibration.txt (`fx fy cx cy`, as of ETH3D) or, without it, that which the benchmark's page
/// gives for freiburg1, freiburg2 or freiburg3, whichever the folder's name holds, else ROS's
/// nominal one (f 525). accelerometer.txt is not read: there is no gyroscope. Errors: kNotFound,
/// kCorrupt, kInvalidInput; one sentence that names the file.
Result<std::shared_ptr<const Sequence>> OpenTumRgbd(const std::filesystem::path& folder,
                                                    const SequenceOptions& options = {});

/// Writes that layout, with a calibration.txt: images (undistorted where the camera distorts),
/// depth and the poses that there are.
Result<WrittenSequence> WriteTumRgbd(const Sequence& sequence, const std::filesystem::path& folder,
                                     const WriteOptions& options, const WorkContext& context);

}  // namespace plumbline
