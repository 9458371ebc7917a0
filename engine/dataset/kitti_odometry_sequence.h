// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there are calib.txt, times.txt and image_2/ or image_0/.
Likeness ProbeKittiOdometry(const std::filesystem::path& path);

/// Opens a folder sequences/NN of KITTI's odometry benchmark: the left colour camera (image_2) or,
/// without it, the left grey one (image_0), rectified, with the P2 or P0 of calib.txt, times.txt
/// [s], and the poses of ../../poses/NN.txt (of the left grey camera in that of frame 0; there are
/// some for 00 to 10) carried over to the camera that is read. `world` is the left grey camera of
/// frame 0, and gravity is not told. Errors: kNotFound, kCorrupt, kInvalidInput; one sentence that
/// names the file.
Result<std::shared_ptr<const Sequence>> OpenKittiOdometry(const std::filesystem::path& folder,
                                                          const SequenceOptions& options = {});

}  // namespace plumbline
