// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/bookmarks.h"

#include <utility>

namespace plumbline {

BookmarkKeeper::BookmarkKeeper(std::function<void()> wake)
    : wake_(std::move(wake)), thread_([this] { Run(); }) {}

BookmarkKeeper::~BookmarkKeeper() { tasks_.Close(); }

void BookmarkKeeper::Read(const std::filesystem::path& file) {
  tasks_.Push(Reading{file, ++last_reading_});
}

void BookmarkKeeper::Write(std::vector<std::filesystem::path> files,
                           std::vector<Bookmark> bookmarks) {
  tasks_.Push(Writing{std::move(files), std::move(bookmarks)});
}

std::optional<std::vector<Bookmark>> BookmarkKeeper::TakeRead() {
  const std::lock_guard lock(mutex_);
  if (!read_ || read_->first != last_reading_) return std::nullopt;
  return std::exchange(read_, std::nullopt)->second;
}

std::optional<Error> BookmarkKeeper::TakeProblem() {
  const std::lock_guard lock(mutex_);
  return std::exchange(problem_, std::nullopt);
}

void BookmarkKeeper::Run() {
  while (const auto task = tasks_.Pop()) {
    std::visit([this](const auto& what) { Do(what); }, *task);
  }
}

void BookmarkKeeper::Do(const Reading& reading) {
  std::vector<Bookmark> bookmarks = ReadBookmarks(reading.file);
  {
    const std::lock_guard lock(mutex_);
    read_ = {reading.number, std::move(bookmarks)};
  }
  wake_();
}

void BookmarkKeeper::Do(const Writing& writing) {
  for (const std::filesystem::path& file : writing.files) {
    const Status status = WriteBookmarks(file, writing.bookmarks);
    if (status.ok()) continue;
    {
      const std::lock_guard lock(mutex_);
      problem_ = status.error();
    }
    wake_();
    return;
  }
}

}  // namespace plumbline
