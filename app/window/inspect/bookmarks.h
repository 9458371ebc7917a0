// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Where the bookmarks of what is open are kept: beside a run file (RUN.plb.bookmarks.json); of a
/// sequence, which may lie where nobody may write, in the folder of the window's settings. Empty:
/// nowhere.
std::filesystem::path BookmarkFile(const std::string& source,
                                   const std::filesystem::path& settings);

/// By frame. None if there is no such file; one that cannot be read is told in the log and left.
std::vector<Bookmark> ReadBookmarks(const std::filesystem::path& file);
/// Removes the file once there are no bookmarks. Errors: kIo.
Status WriteBookmarks(const std::filesystem::path& file, const std::vector<Bookmark>& bookmarks);

}  // namespace plumbline
