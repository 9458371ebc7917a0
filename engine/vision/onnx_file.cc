// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/onnx_file.h"

#include <cstring>
#include <optional>
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

/// The value of a constant of one number.
std::optional<float> ScalarOf(const onnx::TensorProto& tensor) {
  for (const auto length : tensor.dims())
    if (length != 1) return std::nullopt;
  if (tensor.data_type() != onnx::TensorProto::FLOAT) return std::nullopt;
  if (tensor.float_data_size() == 1) return tensor.float_data(0);
  float value = 0;
  if (tensor.raw_data().size() != sizeof(value)) return std::nullopt;
  std::memcpy(&value, tensor.raw_data().data(), sizeof(value));
  return value;
}

/// Bounds that come as inputs become attributes where they are constants. Names of constants that
/// nobody uses then stay in the file: they do no harm.
void MoveBoundsOfClips(onnx::GraphProto& graph) {
  std::map<std::string, float> scalars;
  for (const auto& weight : graph.initializer())
    if (const auto value = ScalarOf(weight)) scalars[weight.name()] = *value;
  for (const auto& node : graph.node()) {
    if (node.op_type() != "Constant" || node.output_size() != 1) continue;
    for (const auto& attribute : node.attribute())
      if (attribute.name() == "value" && attribute.has_t())
        if (const auto value = ScalarOf(attribute.t())) scalars[node.output(0)] = *value;
  }
  for (auto& node : *graph.mutable_node()) {
    if (node.op_type() != "Clip" || node.input_size() < 2) continue;
    bool all_known = true;
    for (int i = 1; i < node.input_size(); ++i)
      all_known &= node.input(i).empty() || scalars.contains(node.input(i));
    if (!all_known) continue;
    for (int i = 1; i < node.input_size() && i < 3; ++i) {
      if (node.input(i).empty()) continue;
      onnx::AttributeProto& bound = *node.add_attribute();
      bound.set_name(i == 1 ? "min" : "max");
      bound.set_type(onnx::AttributeProto::FLOAT);
      bound.set_f(scalars.at(node.input(i)));
    }
    node.mutable_input()->DeleteSubrange(1, node.input_size() - 1);
  }
}

/// Exporters write constants that are equal, such as biases of zero, once and copy them by Identity
/// nodes, which OpenCV 4.6 refuses: whoever takes a copy takes the constant itself.
void DropCopiesOfConstants(onnx::GraphProto& graph, const std::set<std::string>& constants) {
  std::map<std::string, std::string> originals;
  for (int i = 0; i < graph.node_size(); ++i) {
    onnx::NodeProto& node = *graph.mutable_node(i);
    for (std::string& input : *node.mutable_input())
      if (const auto found = originals.find(input); found != originals.end()) input = found->second;
    if (node.op_type() != "Identity" || node.input_size() != 1 || node.output_size() != 1 ||
        !constants.contains(node.input(0)))
      continue;
    originals[node.output(0)] = node.input(0);
    graph.mutable_node()->DeleteSubrange(i--, 1);
  }
}

}  // namespace

Result<OnnxFile> ReadOnnxFile(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    return Error{ErrorCode::kNotFound,
                 "there is no network '" + file.string() + "'; give the path of its file"};
  }
  const Result<std::string> bytes = ReadFile(file);
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
  onnx::GraphProto& graph = *model.mutable_graph();
  std::set<std::string> weights;
  for (const auto& weight : graph.initializer()) weights.insert(weight.name());
  for (int i = graph.input_size() - 1; i >= 0; --i)
    if (weights.contains(graph.input(i).name())) graph.mutable_input()->DeleteSubrange(i, 1);
  for (const auto& input : graph.input()) result.inputs.push_back({input.name(), ShapeOf(input)});
  for (const auto& output : graph.output())
    result.outputs.push_back({output.name(), ShapeOf(output)});
  DropCopiesOfConstants(graph, weights);
  MoveBoundsOfClips(graph);
  result.for_opencv = model.SerializeAsString();
  return result;
}

}  // namespace plumbline
