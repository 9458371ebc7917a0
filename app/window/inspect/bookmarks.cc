// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/bookmarks.h"

#include <fmt/format.h>

#include <functional>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/log.h"

namespace plumbline {

std::filesystem::path BookmarkFile(const std::string& source,
                                   const std::filesystem::path& settings) {
  if (source.empty()) return {};
  if (std::filesystem::path(source).extension() == ".plb") return source + ".bookmarks.json";
  if (settings.empty()) return {};
  const std::string whole = std::filesystem::absolute(source).lexically_normal().string();
  return settings.parent_path() /
         fmt::format("bookmarks-{:016x}.json", std::hash<std::string>{}(whole));
}

std::vector<Bookmark> ReadBookmarks(const std::filesystem::path& file) {
  std::vector<Bookmark> bookmarks;
  if (file.empty() || !std::filesystem::exists(file)) return bookmarks;
  const auto json = ReadJson(file);
  if (!json.ok()) {
    log::warn("the bookmarks are not shown: {}", json.error().message);
    return bookmarks;
  }
  try {
    for (const auto& entry : json->at("bookmarks"))
      bookmarks.push_back({entry.at("frame").get<int>(), entry.value("note", std::string())});
  } catch (const nlohmann::json::exception& error) {
    log::warn("{}: some bookmarks are not shown: {}", file.string(), error.what());
  }
  return bookmarks;
}

Status WriteBookmarks(const std::filesystem::path& file, const std::vector<Bookmark>& bookmarks) {
  if (bookmarks.empty()) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    return {};
  }
  nlohmann::json list = nlohmann::json::array();
  for (const Bookmark& bookmark : bookmarks)
    list.push_back({{"frame", bookmark.frame}, {"note", bookmark.note}});
  std::error_code ignored;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
  return WriteJson(file, {{"bookmarks", list}});
}

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
