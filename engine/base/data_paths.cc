// SPDX-License-Identifier: Apache-2.0
#include "engine/base/data_paths.h"

#include <atomic>

namespace plumbline {
namespace {

std::atomic<bool> outside_is_allowed = false;

}  // namespace

void AllowOutside() { outside_is_allowed = true; }

Result<std::filesystem::path> PlaceInside(const std::filesystem::path& folder,
                                          const std::string& name) {
  const std::filesystem::path relative(name), normal = relative.lexically_normal();
  const bool leaves = relative.is_absolute() || (!normal.empty() && *normal.begin() == "..");
  if (leaves && !outside_is_allowed) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + name + "' leads out of the folder '" + folder.string() +
                     "'; put the file there, or say --allow-outside if that is meant"};
  }
  return folder / relative;
}

bool IsFileName(const std::string& name) {
  return !name.empty() && name != "." && name != ".." &&
         name.find_first_of(std::string("/\0", 2)) == std::string::npos;
}

}  // namespace plumbline
