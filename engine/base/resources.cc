// SPDX-License-Identifier: Apache-2.0
#include "engine/base/resources.h"

#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>

#include "engine/base/files.h"

namespace plumbline {
namespace {
std::mutex& TableMutex() {
  static std::mutex mutex;
  return mutex;
}
std::map<std::string, std::string_view, std::less<>>& Table() {
  static std::map<std::string, std::string_view, std::less<>> table;
  return table;
}
}  // namespace

Result<std::string> LoadResource(std::string_view name) {
  if (const char* root = std::getenv("PLUMBLINE_RESOURCES"); root != nullptr && *root != '\0') {
    return ReadFile(std::filesystem::path(root) / name);
  }
  const std::lock_guard lock(TableMutex());
  const auto found = Table().find(name);
  if (found == Table().end()) {
    return Error{ErrorCode::kNotFound, "no built-in resource '" + std::string(name) + "'"};
  }
  return std::string(found->second);
}

void RegisterResource(std::string_view name, std::string_view data) {
  const std::lock_guard lock(TableMutex());
  Table().insert_or_assign(std::string(name), data);
}

}  // namespace plumbline
