// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace plumbline {

/// What a file or folder is to Plumbline, as far as its name (a project: its content) tells.
enum class PathKind {
  kOther,
  kFolder,  ///< Of nothing in particular.
  kSequence,
  kRun,
  kScan,
  kProject,
  kModels,
  kNetwork
};

struct FolderEntry {
  std::string name;
  PathKind kind = PathKind::kOther;
  bool is_folder = false;
  std::uintmax_t size_bytes = 0;  ///< 0 for folders.
  std::int64_t changed_s = 0;     ///< Seconds since 1970, UTC; 0 where that is not known.
};

/// What is in a folder.
struct FolderView {
  std::string folder;                ///< Absolute.
  std::vector<FolderEntry> entries;  ///< Folders first, then by name, hidden ones too.
  std::string problem;               ///< Why it cannot be read, as a sentence; "": it could.
};

}  // namespace plumbline
