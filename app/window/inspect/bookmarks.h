// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "engine/base/queue.h"
#include "engine/base/result.h"
#include "ui/files/bookmark_file.h"

namespace plumbline {

/// Reads and writes bookmarks on a thread of its own, in the order asked for: the window never
/// waits for a disk.
class BookmarkKeeper {
 public:
  /// @param wake  Called from the thread when something was read or could not be written.
  explicit BookmarkKeeper(std::function<void()> wake);
  /// Writes what is left to write.
  ~BookmarkKeeper();
  BookmarkKeeper(const BookmarkKeeper&) = delete;
  BookmarkKeeper& operator=(const BookmarkKeeper&) = delete;

  void Read(const std::filesystem::path& file);
  void Write(std::vector<std::filesystem::path> files, std::vector<Bookmark> bookmarks);
  /// What the last Read found, once; nothing until then.
  std::optional<std::vector<Bookmark>> TakeRead();
  /// Why something could not be written, once.
  std::optional<Error> TakeProblem();

 private:
  struct Reading {
    std::filesystem::path file;
    int number;  ///< Only the last one counts.
  };
  struct Writing {
    std::vector<std::filesystem::path> files;
    std::vector<Bookmark> bookmarks;
  };

  void Run();
  void Do(const Reading& reading);
  void Do(const Writing& writing);

  std::function<void()> wake_;
  int last_reading_ = 0;  ///< Of the window's thread.
  BoundedQueue<std::variant<Reading, Writing>> tasks_{1024};
  std::mutex mutex_;  ///< Of the two below.
  std::optional<std::pair<int, std::vector<Bookmark>>> read_;
  std::optional<Error> problem_;
  std::jthread thread_;  ///< Last: it uses all of the above.
};

}  // namespace plumbline
