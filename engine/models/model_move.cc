// SPDX-License-Identifier: Apache-2.0
#include "engine/models/model_move.h"

#include <algorithm>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/models/mesh_file.h"

namespace plumbline {
namespace {

using std::filesystem::path;

Result<nlohmann::json> ReadList(const path& folder) {
  auto json = ReadJson(folder / "models.json");
  if (!json) return json.error();
  if (!json->is_object() || !json->contains("models") || !(*json)["models"].is_array()) {
    return Error{ErrorCode::kCorrupt,
                 "'" + (folder / "models.json").string() + "' is no list of models"};
  }
  return json;
}

nlohmann::json::iterator Find(nlohmann::json& list, const std::string& name) {
  return std::find_if(list.begin(), list.end(), [&](const nlohmann::json& entry) {
    return entry.is_object() && entry.value("name", nlohmann::json()) == name;
  });
}

/// The mesh and, if it has one, its texture.
std::vector<std::string> FilesOf(const path& folder, const nlohmann::json& entry) {
  std::vector<std::string> files;
  if (!entry.contains("file") || !entry["file"].is_string()) return files;
  files.push_back(entry["file"]);
  const auto mesh = ReadMesh(folder / files.front());
  if (mesh && !mesh->texture_file.empty()) files.push_back(mesh->texture_file);
  return files;
}

}  // namespace

bool HasModel(const path& folder, const std::string& name) {
  auto json = ReadList(folder);
  return json.ok() && Find((*json)["models"], name) != (*json)["models"].end();
}

Status MoveModel(const std::string& name, const path& from, const path& to) {
  auto source = ReadList(from);
  if (!source) return source.error();
  const auto found = Find((*source)["models"], name);
  if (found == (*source)["models"].end()) {
    return Error{ErrorCode::kNotFound, "'" + from.string() + "' has no model '" + name + "'"};
  }
  std::error_code error;
  std::filesystem::create_directories(to, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + to.string() + "': " + error.message()};
  }
  nlohmann::json target = {{"units", (*source).value("units", nlohmann::json("m"))},
                           {"models", nlohmann::json::array()}};
  if (std::filesystem::exists(to / "models.json", error)) {
    auto existing = ReadList(to);
    if (!existing) return existing.error();
    target = std::move(*existing);
  }
  const std::vector<std::string> files = FilesOf(from, *found);
  for (const std::string& file : files) {
    const auto content = ReadFile(from / file);
    if (!content) return content.error();
    if (const Status copied = WriteFileAtomically(to / file, *content); !copied.ok()) return copied;
  }
  const auto there = Find(target["models"], name);
  if (there == target["models"].end()) {
    target["models"].push_back(*found);
  } else {
    *there = *found;
  }
  if (const Status entered = WriteJson(to / "models.json", target); !entered.ok()) return entered;
  (*source)["models"].erase(found);
  if (const Status left = WriteJson(from / "models.json", *source); !left.ok()) return left;
  for (const std::string& file : files) std::filesystem::remove(from / file, error);
  return {};
}

}  // namespace plumbline
