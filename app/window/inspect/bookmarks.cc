// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/bookmarks.h"

#include <fmt/format.h>

#include <functional>

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

}  // namespace plumbline
