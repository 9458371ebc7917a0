// SPDX-License-Identifier: Apache-2.0
#include "ui/files/bookmark_file.h"

#include <fmt/format.h>

#include <functional>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/log.h"
#include "ui/files/kept_value.h"
#include "ui/files/window_settings.h"

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
  std::error_code ignored;
  if (file.empty() || !std::filesystem::exists(file, ignored)) return bookmarks;
  const auto json = ReadJson(file);
  if (!json.ok()) {
    log::warn("the bookmarks are not shown: {}{}", json.error().message, SetAside(file));
    return bookmarks;
  }
  const auto list = json->find("bookmarks");
  bool whole = list != json->end() && list->is_array();
  for (const auto& entry : whole ? *list : nlohmann::json::array()) {
    const int frame = KeptValue(entry, "frame", -1);
    if (frame >= 0)
      bookmarks.push_back({frame, KeptValue(entry, "note", std::string())});
    else
      whole = false;
  }
  if (!whole)
    log::warn("{} is damaged: some bookmarks are not shown{}", file.string(), SetAside(file));
  return bookmarks;
}

Status WriteBookmarks(const std::filesystem::path& file, const std::vector<Bookmark>& bookmarks) {
  std::error_code ignored;
  if (bookmarks.empty()) {
    std::filesystem::remove(file, ignored);
    return {};
  }
  nlohmann::json list = nlohmann::json::array();
  for (const Bookmark& bookmark : bookmarks)
    list.push_back({{"frame", bookmark.frame}, {"note", bookmark.note}});
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
  return WriteJson(file, {{"bookmarks", list}});
}

}  // namespace plumbline
