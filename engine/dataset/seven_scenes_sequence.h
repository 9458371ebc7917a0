// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there is a frame-NNNNNN.color.png, possible where folders seq-NN hold some.
Likeness ProbeSevenScenes(const std::filesystem::path& path);

/// Opens a folder seq-NN of 7-Scenes (Microsoft Research): frame-NNNNNN.color.png, .depth.png (16
/// bits, mm, 65535 = none) and .pose.txt (4x4, world_from_cam). 30 Hz; frames that are missing
/// leave a gap. The camera is the nominal one of the data set's page, f 585 px and centre (320,
/// 240), which is that of the depth camera: colour and depth are not registered. `world` is that of
/// the first frames, and gravity is not known. Poses that are not rigid transforms are left out
/// with a warning. Errors: kNotFound, kCorrupt, kInvalidInput; one sentence that names the file.
Result<std::shared_ptr<const Sequence>> OpenSevenScenes(const std::filesystem::path& folder,
                                                        const SequenceOptions& options = {});

}  // namespace plumbline
