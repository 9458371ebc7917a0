// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/folder_reader.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "engine/base/files.h"
#include "engine/dataset/sequence_formats.h"

namespace plumbline {
namespace {

std::string LowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// By its content, since any JSON may have that ending.
bool IsProject(const std::filesystem::path& file, std::uintmax_t size_bytes) {
  constexpr std::uintmax_t kLargest = 8 << 20;
  if (size_bytes > kLargest) return file.filename().string().ends_with(".annotation.json");
  const auto content = ReadFile(file);
  return content.ok() && content->find("\"plumbline_annotation\"") != std::string::npos;
}

PathKind KindOfFolder(const std::filesystem::path& folder) {
  const SequenceFormat* format = FindSequenceFormat(folder);
  if (format != nullptr && format->probe(folder) == Likeness::kCertain) return PathKind::kSequence;
  std::error_code ignored;
  return std::filesystem::exists(folder / "models.json", ignored) ? PathKind::kModels
                                                                  : PathKind::kFolder;
}

PathKind KindOfFile(const std::filesystem::path& file, std::uintmax_t size_bytes) {
  constexpr std::array<std::pair<std::string_view, PathKind>, 7> kEndings = {
      {{".plb", PathKind::kRun},
       {".bag", PathKind::kSequence},
       {".sens", PathKind::kSequence},
       {".ply", PathKind::kScan},
       {".pcd", PathKind::kScan},
       {".obj", PathKind::kScan},
       {".onnx", PathKind::kNetwork}}};
  const std::string ending = LowerCase(file.extension().string());
  for (const auto& [known, kind] : kEndings) {
    if (ending == known) return kind;
  }
  if (ending == ".json" && IsProject(file, size_bytes)) return PathKind::kProject;
  return PathKind::kOther;
}

}  // namespace

FolderView ReadFolder(const std::filesystem::path& folder, const std::function<bool()>& given_up) {
  FolderView view{.folder = folder.string()};
  std::error_code error;
  std::filesystem::directory_iterator at(folder, error);
  for (; !error && at != std::filesystem::directory_iterator(); at.increment(error)) {
    if (given_up()) return view;
    const std::filesystem::path& path = at->path();
    FolderEntry entry{.name = path.filename().string()};
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) continue;  // a link to nothing
    entry.is_folder = S_ISDIR(status.st_mode);
    entry.changed_s = status.st_mtime;
    if (!entry.is_folder) entry.size_bytes = static_cast<std::uintmax_t>(status.st_size);
    entry.kind = entry.is_folder ? KindOfFolder(path) : KindOfFile(path, entry.size_bytes);
    view.entries.push_back(std::move(entry));
  }
  if (error) {
    view.problem = error == std::errc::permission_denied
                       ? "You may not read the folder " + view.folder + "."
                   : error == std::errc::no_such_file_or_directory
                       ? "There is no folder " + view.folder + "."
                       : "The folder " + view.folder + " cannot be read: " + error.message() + ".";
  }
  std::vector<std::pair<std::string, FolderEntry>> keyed;
  keyed.reserve(view.entries.size());
  for (FolderEntry& entry : view.entries) {
    std::string key = LowerCase(entry.name);
    keyed.emplace_back(std::move(key), std::move(entry));
  }
  std::sort(keyed.begin(), keyed.end(), [](const auto& a, const auto& b) {
    if (a.second.is_folder != b.second.is_folder) return a.second.is_folder;
    return std::tie(a.first, a.second.name) < std::tie(b.first, b.second.name);
  });
  view.entries.clear();
  for (auto& [key, entry] : keyed) view.entries.push_back(std::move(entry));
  return view;
}

void FolderReader::Read(const std::filesystem::path& folder) {
  const std::uint64_t mine = ++asked_;
  worker_.Do([this, folder, mine] {
    const auto given_up = [&] { return asked_ != mine; };
    if (given_up()) return;
    FolderView view = ReadFolder(folder, given_up);
    if (given_up()) return;
    view_.Publish(std::make_shared<const FolderView>(std::move(view)));
    if (on_publish_) on_publish_();
  });
}

}  // namespace plumbline
