// SPDX-License-Identifier: Apache-2.0
#include "engine/base/random_access_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <utility>

namespace plumbline {

Result<RandomAccessFile> RandomAccessFile::Open(const std::filesystem::path& path) {
  RandomAccessFile file;
  file.path_ = path;
  // Without waiting: a pipe would, for somebody to write into it.
  file.descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat state = {};
  if (file.descriptor_ < 0 || fstat(file.descriptor_, &state) != 0 || !S_ISREG(state.st_mode))
    return Error{ErrorCode::kNotFound, "cannot open '" + path.string() + "'"};
  file.size_ = static_cast<std::uint64_t>(state.st_size);
  return file;
}

RandomAccessFile::RandomAccessFile(RandomAccessFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

RandomAccessFile& RandomAccessFile::operator=(RandomAccessFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

RandomAccessFile::~RandomAccessFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

Error RandomAccessFile::Damage(const std::string& what) const {
  return {ErrorCode::kCorrupt, "'" + path_.string() + "' is damaged: " + what};
}

Result<std::string> RandomAccessFile::Read(std::uint64_t begin, std::uint64_t count) const {
  if (begin > size_ || count > size_ - begin) return Damage("it ends before what it says to hold");
  std::string bytes(count, '\0');
  for (std::uint64_t done = 0; done < count;) {
    const ssize_t now =
        pread(descriptor_, bytes.data() + done, count - done, static_cast<off_t>(begin + done));
    if (now <= 0) return Error{ErrorCode::kIo, "cannot read '" + path_.string() + "'"};
    done += static_cast<std::uint64_t>(now);
  }
  return bytes;
}

}  // namespace plumbline
