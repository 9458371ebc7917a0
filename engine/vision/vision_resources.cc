// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/vision_resources.h"

#include <mutex>

#include "engine/base/check.h"
#include "engine/base/resources.h"

void RegisterResources_plumbline_vision();  // made by cmake/Embed.cmake

namespace plumbline {

std::string VisionResource(std::string_view name) {
  static std::once_flag registered;
  std::call_once(registered, RegisterResources_plumbline_vision);
  Result<std::string> content = LoadResource(name);
  PLB_CHECK(content.ok());
  return std::move(content).value();
}

}  // namespace plumbline
