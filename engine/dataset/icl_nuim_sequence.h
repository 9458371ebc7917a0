// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there is a NAME.gt.freiburg beside the folder rgb/.
Likeness ProbeIclNuim(const std::filesystem::path& path);

/// Opens a folder of ICL-NUIM's "TUM RGB-D compatible PNGs": rgb/N.png, depth/N.png (16 bits, 5000
/// to the metre) and NAME.gt.freiburg, whose first column is the number of the image. 30 Hz.
/// Camera: 481.20, 480.00, (319.5, 239.5).
///
/// The poses are those of the renderer, whose camera and world have y UP and are left-handed; the
/// data set's page gives it a negative fy for that. The images are stored top row first, as usual.
/// Poses are therefore mirrored in y on both sides, M * pose * M with M = diag(1, -1, 1), which
/// makes `cam` y down and `world` right-handed with y down: gravity is +y. (Verified in
/// nvidia-isaac/cuVSLAM pull request 135; K from ankurhanda/living_room_iclnuim.) Errors:
/// kNotFound, kCorrupt, kInvalidInput; one sentence that names the file.
Result<std::shared_ptr<const Sequence>> OpenIclNuim(const std::filesystem::path& folder,
                                                    const SequenceOptions& options = {});

}  // namespace plumbline
