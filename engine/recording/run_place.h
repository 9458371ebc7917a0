// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a run file begins, replaces an older one and ends, so that a kill at any write leaves a file
// that can be read from a folder without write permission. For the sources of this folder.

#include <filesystem>

#include "engine/base/result.h"
#include "engine/recording/sqlite.h"

namespace plumbline {

/// Where a new run is written until it is complete enough to take the place of an older one.
std::filesystem::path PlaceBeside(const std::filesystem::path& file);

/// Removes a run and its companions. Errors: kIo.
Status RemoveRun(const std::filesystem::path& file);

/// A new run may take the place of an older one or of an empty file, but never of anything else.
/// Errors: kInvalidInput.
Status CheckReplaceable(const std::filesystem::path& file);

/// Moves a run that nobody has open from `beside` to `file`. Whatever ends the program, the old
/// run or the new one is there. Errors: kIo.
Status PutInPlace(const std::filesystem::path& beside, const std::filesystem::path& file);

/// From now on what is written goes to a log beside the file: frames survive a killed program
/// without waiting for the disk; a power cut costs at most the last seconds.
Status UseWriteAheadLog(sqlite::Database& database);

/// Makes one plain file of file and log. Errors: kIo, also while somebody reads; then the log
/// stays, and nothing is lost.
Status FoldLog(sqlite::Database& database);

}  // namespace plumbline
