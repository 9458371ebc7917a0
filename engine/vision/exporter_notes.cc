// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/exporter_notes.h"

#include <yaml-cpp/yaml.h>

#include "engine/vision/category_names.h"

namespace plumbline {

std::vector<std::string> NotedNames(const OnnxFile& onnx) {
  std::vector<std::string> names;
  const auto found = onnx.metadata.find("names");
  if (found == onnx.metadata.end()) return names;
  try {
    const YAML::Node node = YAML::Load(found->second);
    for (std::size_t i = 0; i < node.size(); ++i) {
      const YAML::Node name = node.IsMap() ? node[static_cast<int>(i)] : node[i];
      if (!name || !name.IsScalar()) return {};
      names.push_back(CategoryName(name.as<std::string>()));
    }
  } catch (const YAML::Exception&) {
    return {};
  }
  return names;
}

std::optional<cv::Size> NotedSize(const OnnxFile& onnx) {
  const auto found = onnx.metadata.find("imgsz");
  if (found == onnx.metadata.end()) return std::nullopt;
  try {
    const YAML::Node node = YAML::Load(found->second);
    if (node.IsSequence() && node.size() == 2)
      return cv::Size(node[1].as<int>(), node[0].as<int>());
  } catch (const YAML::Exception&) {
  }
  return std::nullopt;
}

}  // namespace plumbline
