// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/verb.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/base/log.h"

namespace plumbline {

void Warn(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) log::warn("{}", warning);
}

Result<std::filesystem::path> ThisProgram() {
  std::error_code error;
  std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) return program;
  return Error{ErrorCode::kIo, "cannot tell where this program is: " + error.message()};
}

Status WriteJsonResult(const std::string& file, const nlohmann::json& json) {
  if (file == "-") {
    std::cout << json.dump(1) << std::endl;
    return {};
  }
  return WriteJson(file, json);
}

}  // namespace plumbline
