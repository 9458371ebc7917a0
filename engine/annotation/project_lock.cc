// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/project_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace plumbline {

Result<std::unique_ptr<ProjectLock>> ProjectLock::Acquire(const std::filesystem::path& project) {
  // The file stays when the lock is given back: removing it would race with the next holder.
  const std::string file = project.string() + ".lock";
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) {
    return Error{ErrorCode::kIo, "cannot write '" + file + "': " + std::strerror(errno) +
                                     "; open the project for reading, or save it elsewhere"};
  }
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    const int error = errno;
    char holder[256] = {};
    const ssize_t size = ::pread(descriptor, holder, sizeof(holder) - 1, 0);
    ::close(descriptor);
    if (error != EWOULDBLOCK) {
      return Error{ErrorCode::kIo, "cannot lock '" + file + "': " + std::strerror(error)};
    }
    return Error{ErrorCode::kInvalidInput, "'" + project.string() + "' is open in another window" +
                                               (size > 0 ? " (" + std::string(holder) + ")" : "") +
                                               "; close it there, or open it for reading"};
  }
  char host[128] = {};
  ::gethostname(host, sizeof(host) - 1);
  const std::string text = "process " + std::to_string(::getpid()) + " on " + host;
  if (::ftruncate(descriptor, 0) == 0) {
    static_cast<void>(!::pwrite(descriptor, text.data(), text.size(), 0));
  }
  return std::unique_ptr<ProjectLock>(new ProjectLock(descriptor));
}

ProjectLock::~ProjectLock() { ::close(descriptor_); }

}  // namespace plumbline
