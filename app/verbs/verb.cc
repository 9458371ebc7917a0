// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/verb.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"

namespace plumbline {

Status WriteJsonResult(const std::string& file, const nlohmann::json& json) {
  if (file == "-") {
    std::cout << json.dump(1) << std::endl;
    return {};
  }
  return WriteJson(file, json);
}

}  // namespace plumbline
