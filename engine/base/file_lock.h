// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/result.h"

namespace plumbline {

/// Claims a file for one writer among all processes of this machine, by a lock on FILE.lock beside
/// it. The system gives the lock back when the process ends, however it ends; a FILE.lock that a
/// killed process left behind locks nothing.
class FileLock {
 public:
  /// Errors: kInvalidInput, saying which process holds it; kIo (the folder cannot be written). The
  /// caller adds what to do about it.
  static Result<std::unique_ptr<FileLock>> Acquire(const std::filesystem::path& file);
  /// Whether somebody holds it now.
  static bool IsHeld(const std::filesystem::path& file);
  /// Removes a FILE.lock that a killed process left behind; call it where the file is read.
  static void RemoveStale(const std::filesystem::path& file);
  /// Removes FILE.lock.
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  FileLock(std::filesystem::path path, int descriptor)
      : path_(std::move(path)), descriptor_(descriptor) {}
  std::filesystem::path path_;
  int descriptor_;
};

}  // namespace plumbline
