// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace plumbline {

/// A run of four frames, written without mapping anything, and what it names: `room.plb`, the
/// sequence `walk` and the database `models` (chair, and table of two-fold symmetry). At its end
/// there are a confirmed chair (1) of one mode, whose particles have not changed for a frame, a
/// confirmed table (4) of two modes and a tentative chair (5); frame 2 was skipped. It has been
/// smoothed. `particles.json` tells the particles of the table in the last frame, column by column.
void WriteRecordedRoom(const std::filesystem::path& folder);

}  // namespace plumbline
