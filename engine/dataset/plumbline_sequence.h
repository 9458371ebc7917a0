// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {

/// Certain where there is a camera.json, possible where there are images or tracks alone.
Likeness ProbePlumblineSequence(const std::filesystem::path& path);

/// Opens a folder in Plumbline's own layout (docs/formats.md). Frames are the rows of color.csv by
/// stamp or, without it, the images of color/ by number (gaps are fine: a frame's index is its
/// position), or the stamps of tracks.csv where there are no images. Poses join frames by stamp
/// within half a period. Reads the small files and the folder's names, no image. Errors: kNotFound,
/// kCorrupt, kInvalidInput, kUnsupported; one sentence that names the file.
Result<std::shared_ptr<const Sequence>> OpenPlumblineSequence(const std::filesystem::path& folder,
                                                              const SequenceOptions& options = {});

}  // namespace plumbline
