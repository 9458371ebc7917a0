// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "engine/base/result.h"

namespace plumbline {

/// Where a run file is written; removed with its companions if it is only for the time being.
class RunFilePlace {
 public:
  /// @param wanted  Empty: a file in a new temporary folder. Errors: kIo.
  static Result<RunFilePlace> Choose(const std::filesystem::path& wanted);
  RunFilePlace(RunFilePlace&& other) noexcept
      : path_(std::move(other.path_)), folder_(std::exchange(other.folder_, {})) {}
  RunFilePlace(const RunFilePlace&) = delete;
  RunFilePlace& operator=(const RunFilePlace&) = delete;
  ~RunFilePlace();

  const std::filesystem::path& path() const { return path_; }

 private:
  RunFilePlace() = default;
  std::filesystem::path path_, folder_;
};

/// Whether a run file is such a temporary one.
bool IsTemporaryRun(const std::filesystem::path& run);

}  // namespace plumbline
