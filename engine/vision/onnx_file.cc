// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/onnx_file.h"

#include <set>

#include <onnx/onnx_pb.h>

#include "engine/base/files.h"

namespace plumbline {
namespace {

std::vector<int> ShapeOf(const onnx::ValueInfoProto& value) {
  std::vector<int> shape;
  for (const auto& length : value.type().tensor_type().shape().dim())
    shape.push_back(length.has_dim_value() ? static_cast<int>(length.dim_value()) : 0);
  return shape;
}

}  // namespace

Result<OnnxFile> ReadOnnxFile(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    return Error{ErrorCode::kNotFound,
                 "there is no network '" + file.string() + "'; give the path of its file"};
  }
  Result<std::string> bytes = ReadFile(file);
  if (!bytes.ok()) return bytes.error();
  onnx::ModelProto model;
  if (!model.ParseFromString(*bytes) || model.graph().node_size() == 0) {
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' is no ONNX network, or is damaged; export it again"};
  }
  OnnxFile result;
  result.content_hash = HashHex(*bytes);
  result.producer = model.producer_name();
  if (!model.producer_version().empty()) result.producer += " " + model.producer_version();
  for (const auto& entry : model.metadata_props()) result.metadata[entry.key()] = entry.value();
  const onnx::GraphProto& graph = model.graph();
  std::set<std::string> weights;
  for (const auto& weight : graph.initializer()) weights.insert(weight.name());
  for (const auto& input : graph.input())
    if (!weights.contains(input.name())) result.inputs.push_back({input.name(), ShapeOf(input)});
  for (const auto& output : graph.output())
    result.outputs.push_back({output.name(), ShapeOf(output)});
  result.bytes = std::move(bytes).value();
  return result;
}

}  // namespace plumbline
