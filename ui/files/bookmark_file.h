// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace plumbline {

/// A frame to come back to.
struct Bookmark {
  int frame = 0;
  std::string note;
};

/// Where the bookmarks of what is open are kept: beside a run file (RUN.plb.bookmarks.json); of a
/// sequence, which may lie where nobody may write, in the folder of the window's settings. Empty:
/// nowhere.
std::filesystem::path BookmarkFile(const std::string& source,
                                   const std::filesystem::path& settings);

/// By frame. None if there is no such file. Of one that is damaged, those that can be read: the log
/// tells, and a copy stays beside it (SetAside).
std::vector<Bookmark> ReadBookmarks(const std::filesystem::path& file);
/// Removes the file once there are no bookmarks. Errors: kIo.
Status WriteBookmarks(const std::filesystem::path& file, const std::vector<Bookmark>& bookmarks);

}  // namespace plumbline
