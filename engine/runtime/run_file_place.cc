// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/run_file_place.h"

#include <stdlib.h>

namespace plumbline {
namespace {

constexpr const char *kTemporaryFolder = "plumbline_XXXXXX", *kTemporaryRun = "live.plb";

}  // namespace

Result<RunFilePlace> RunFilePlace::Choose(const std::filesystem::path& wanted) {
  RunFilePlace place;
  place.path_ = wanted;
  if (!wanted.empty()) return place;
  std::string folder = (std::filesystem::temp_directory_path() / kTemporaryFolder).string();
  if (mkdtemp(folder.data()) == nullptr) {
    return Error{ErrorCode::kIo, "cannot make a temporary folder in '" +
                                     std::filesystem::temp_directory_path().string() +
                                     "' to record into"};
  }
  place.folder_ = folder;
  place.path_ = place.folder_ / kTemporaryRun;
  return place;
}

RunFilePlace::~RunFilePlace() {
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

bool IsTemporaryRun(const std::filesystem::path& run) {
  std::error_code ignored;
  const std::filesystem::path folder = run.parent_path();
  return run.filename() == kTemporaryRun && folder.filename().string().starts_with("plumbline_") &&
         folder.parent_path() == std::filesystem::temp_directory_path(ignored);
}

}  // namespace plumbline
