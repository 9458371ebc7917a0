// SPDX-License-Identifier: Apache-2.0
#include "engine/base/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>

namespace plumbline {
namespace {

/// Whether `path` still names the open file: its last holder may have removed it meanwhile.
bool IsAt(int descriptor, const std::filesystem::path& path) {
  struct stat open_file {
  }, named_file{};
  return ::fstat(descriptor, &open_file) == 0 && ::stat(path.c_str(), &named_file) == 0 &&
         open_file.st_dev == named_file.st_dev && open_file.st_ino == named_file.st_ino;
}

/// What another user left behind may be readable only; that is enough for a lock.
int OpenLockFile(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor >= 0 || errno != EACCES) return descriptor;
  const int readable = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (readable < 0) errno = EACCES;
  return readable;
}

Error InUse(const std::filesystem::path& file, int descriptor) {
  char holder[256] = {};
  const ssize_t size = ::pread(descriptor, holder, sizeof(holder) - 1, 0);
  return {ErrorCode::kInvalidInput,
          "'" + file.string() + "' is open in another window or command" +
              (size > 0 ? " (" + std::string(holder) + ")" : std::string())};
}

/// Of a file with two names there is one lock.
std::filesystem::path LockFileOf(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::path target = std::filesystem::weakly_canonical(file, error);
  if (error) target = std::filesystem::absolute(file, error);
  return target.string() + ".lock";
}

}  // namespace

bool FileLock::IsHeld(const std::filesystem::path& file) {
  const int descriptor = ::open(LockFileOf(file).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool held = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  return held;
}

void FileLock::RemoveStale(const std::filesystem::path& file) {
  const std::filesystem::path path = LockFileOf(file);
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 && IsAt(descriptor, path)) ::unlink(path.c_str());
  ::close(descriptor);
}

Result<std::unique_ptr<FileLock>> FileLock::Acquire(const std::filesystem::path& file) {
  const std::filesystem::path path = LockFileOf(file);
  int patience = 5;  // IsHeld and RemoveStale of others hold it for a moment
  while (true) {
    const int descriptor = OpenLockFile(path);
    if (descriptor < 0) {
      return Error{ErrorCode::kIo, "cannot write '" + path.string() + "': " + std::strerror(errno)};
    }
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
      const int reason = errno;
      const Error in_use = InUse(file, descriptor);
      ::close(descriptor);
      if (reason == EWOULDBLOCK && patience-- > 0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        continue;
      }
      if (reason == EWOULDBLOCK) return in_use;
      return Error{ErrorCode::kIo, "cannot lock '" + path.string() + "': " + std::strerror(reason)};
    }
    if (!IsAt(descriptor, path)) {
      ::close(descriptor);
      continue;
    }
    char host[128] = {};
    ::gethostname(host, sizeof(host) - 1);
    const std::string text = "process " + std::to_string(::getpid()) + " on " + host;
    if (::ftruncate(descriptor, 0) == 0) {
      static_cast<void>(!::pwrite(descriptor, text.data(), text.size(), 0));
    }
    return std::unique_ptr<FileLock>(new FileLock(path, descriptor));
  }
}

FileLock::~FileLock() {
  // While it is held: who opened the file before now finds it gone, and makes a new one.
  ::unlink(path_.c_str());
  ::close(descriptor_);
}

}  // namespace plumbline
