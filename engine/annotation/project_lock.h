// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"

namespace plumbline {

/// Holds a project for one window. The system gives it back when the process ends, however it ends.
class ProjectLock {
 public:
  /// Errors: kInvalidInput, saying which process holds it; kIo (the folder cannot be written).
  static Result<std::unique_ptr<ProjectLock>> Acquire(const std::filesystem::path& project);
  ~ProjectLock();
  ProjectLock(const ProjectLock&) = delete;
  ProjectLock& operator=(const ProjectLock&) = delete;

 private:
  explicit ProjectLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace plumbline
