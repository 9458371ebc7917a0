// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "engine/base/result.h"

namespace plumbline {

/// A file that is read in pieces, wherever they lie. Safe to call from several threads.
class RandomAccessFile {
 public:
  /// Errors: kNotFound for what is no file that can be opened.
  static Result<RandomAccessFile> Open(const std::filesystem::path& file);
  RandomAccessFile(RandomAccessFile&& other) noexcept;
  RandomAccessFile& operator=(RandomAccessFile&& other) noexcept;
  ~RandomAccessFile();

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  /// "'FILE' is damaged: WHAT".
  Error Damage(const std::string& what) const;
  /// Errors: kCorrupt beyond the end of the file; kIo.
  Result<std::string> Read(std::uint64_t begin, std::uint64_t count) const;

 private:
  RandomAccessFile() = default;

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace plumbline
