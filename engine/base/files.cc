// SPDX-License-Identifier: Apache-2.0
#include "engine/base/files.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "engine/base/json_text.h"

namespace plumbline {
namespace {

constexpr std::size_t kPieceBytes = 1 << 16;  ///< That are read at a time.

Error IoError(std::string_view doing, const std::filesystem::path& path) {
  return {ErrorCode::kIo,
          "cannot " + std::string(doing) + " '" + path.string() + "': " + std::strerror(errno)};
}

bool WriteAll(int file, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(file, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return ::fsync(file) == 0;
}

std::filesystem::path FolderOf(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

/// Writes a file that gets its name only when it is complete, so that nothing stays behind if the
/// process is killed meanwhile. False where the file system cannot do that.
bool WriteNameless(const std::filesystem::path& path, std::string_view content) {
  const int file = ::open(FolderOf(path).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0644);
  if (file < 0) return false;
  const std::string open_file = "/proc/self/fd/" + std::to_string(file);
  const bool written = WriteAll(file, content) && ::linkat(AT_FDCWD, open_file.c_str(), AT_FDCWD,
                                                           path.c_str(), AT_SYMLINK_FOLLOW) == 0;
  const int error = errno;
  ::close(file);
  errno = error;
  return written;
}

constexpr std::string_view kTemporary = ".tmp";
constexpr std::chrono::minutes kLongAgo(10);

/// Whether it is NAME.tmpPID-N of a process that is gone. Not if it is young: another machine may
/// be writing it.
bool IsLeftover(const std::filesystem::directory_entry& entry) {
  const std::string name = entry.path().filename().string();
  const std::size_t at = name.rfind(kTemporary);
  if (at == std::string::npos || at == 0) return false;
  char* end = nullptr;
  const long pid = std::strtol(name.c_str() + at + kTemporary.size(), &end, 10);
  if (pid <= 0 || *end != '-') return false;
  std::error_code failed;
  const auto written = entry.last_write_time(failed);
  return !failed && std::filesystem::file_time_type::clock::now() - written > kLongAgo &&
         ::kill(static_cast<pid_t>(pid), 0) != 0 && errno == ESRCH;
}

/// Removes what processes that were killed left in the folder; once, since folders may be large.
void RemoveLeftovers(const std::filesystem::path& folder) {
  static std::mutex mutex;
  static std::set<std::filesystem::path> seen;
  {
    const std::lock_guard lock(mutex);
    if (!seen.insert(folder).second) return;
  }
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (IsLeftover(entry)) ::unlink(entry.path().c_str());
  }
}

bool WriteNamed(const std::filesystem::path& path, std::string_view content) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return false;
  const bool written = WriteAll(file, content);
  const int error = errno;
  ::close(file);
  errno = error;
  return written;
}

}  // namespace

Result<std::string> ReadFile(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return Error{ErrorCode::kNotFound, "there is no file '" + path.string() + "'"};
  }
  if (std::filesystem::is_directory(path, ignored)) {
    return Error{ErrorCode::kInvalidInput, "'" + path.string() + "' is a folder; a file is needed"};
  }
  // Reading a device need never end, nor opening a pipe that nobody writes to.
  if (!std::filesystem::is_regular_file(path, ignored)) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + path.string() + "' is a device, pipe or socket; a file is needed"};
  }
  std::ifstream file(path, std::ios::binary);
  std::string content;
  for (std::vector<char> piece(kPieceBytes); file;) {
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    content.append(piece.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (!file.good() && !file.eof()) return IoError("read", path);
  return content;
}

Status WriteFileAtomically(const std::filesystem::path& path, std::string_view content) {
  static std::atomic<int> count = 0;
  const std::filesystem::path temporary = path.string() + std::string(kTemporary) +
                                          std::to_string(::getpid()) + "-" +
                                          std::to_string(count++);
  const bool written = WriteNameless(temporary, content) || WriteNamed(temporary, content);
  if (!written || ::rename(temporary.c_str(), path.c_str()) != 0) {
    const Error error = IoError("write", path);
    ::unlink(temporary.c_str());
    return error;
  }
  SyncFolderOf(path);
  RemoveLeftovers(FolderOf(path));
  return {};
}

void SyncFolderOf(const std::filesystem::path& path) {
  const int directory = ::open(FolderOf(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return;
  ::fsync(directory);
  ::close(directory);
}

Result<nlohmann::json> ReadJson(const std::filesystem::path& path) {
  Result<std::string> text = ReadFile(path);
  if (!text.ok()) return text.error();
  if (IsTooDeep(*text)) {
    return Error{ErrorCode::kCorrupt, "'" + path.string() +
                                          "' is no JSON of ours: it nests more than " +
                                          std::to_string(kDeepestJson) + " levels"};
  }
  try {
    return nlohmann::json::parse(*text, nullptr, true, true);
  } catch (const nlohmann::json::exception& error) {
    return Error{ErrorCode::kCorrupt, "'" + path.string() + "' is not valid JSON: " + error.what()};
  }
}

Status WriteJson(const std::filesystem::path& path, const nlohmann::json& json) {
  return WriteFileAtomically(path, JsonText(json, 1) + "\n");
}

std::string JsonText(const nlohmann::json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string HashHex(std::string_view content) {
  static constexpr char kDigits[] = "0123456789abcdef";
  const std::uint64_t hash = XXH3_64bits(content.data(), content.size());
  std::string text(16, '0');
  for (int i = 0; i < 16; ++i) text[i] = kDigits[(hash >> (60 - 4 * i)) & 15];
  return text;
}

Result<std::string> HashFile(const std::filesystem::path& path) {
  Result<std::string> content = ReadFile(path);
  if (!content.ok()) return content.error();
  return HashHex(*content);
}

std::filesystem::path CacheDirectory() {
  std::filesystem::path base;
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0') {
    base = cache;
  } else if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    base = std::filesystem::path(home) / ".cache";
  } else {
    base = std::filesystem::temp_directory_path();
  }
  const std::filesystem::path folder = base / "plumbline";
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  return folder;
}

}  // namespace plumbline
