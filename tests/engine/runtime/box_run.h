// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/mapping/map_report.h"
#include "engine/recording/run_header.h"

namespace plumbline {

/// A box as OBJ, in a database folder.
void WriteBoxModels(const std::filesystem::path& folder);

/// Frames of a 960x500 sequence whose image files are a few, linked under many names.
void WriteBoxSequence(const std::filesystem::path& folder, int frames);

/// Of a run on these two.
RunHeader HeaderOfBoxRun(const std::filesystem::path& sequence,
                         const std::filesystem::path& models);

/// Three confirmed boxes before the camera.
FrameReport FrameOfBoxRun(int frame);

}  // namespace plumbline
