// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/onnx_folding.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <onnx/onnx_pb.h>
#include <onnx/shape_inference/implementation.h>

namespace plumbline {
namespace {

/// Whole numbers in a row; a single one may be a scalar.
struct Whole {
  std::vector<std::int64_t> values;
  bool is_scalar = false;
};
constexpr std::size_t kMostWhole = 64;  // shapes are short; longer constants are data
constexpr int kMostRounds = 8;          // what is folded tells more shapes, and so on

std::optional<Whole> WholeOf(const onnx::TensorProto& tensor) {
  if (tensor.data_type() != onnx::TensorProto::INT64 || tensor.dims_size() > 1) return std::nullopt;
  const std::size_t count = tensor.dims_size() == 0 ? 1 : static_cast<std::size_t>(tensor.dims(0));
  if (count > kMostWhole) return std::nullopt;
  Whole whole{std::vector<std::int64_t>(count), tensor.dims_size() == 0};
  if (static_cast<std::size_t>(tensor.int64_data_size()) == count) {
    std::copy(tensor.int64_data().begin(), tensor.int64_data().end(), whole.values.begin());
  } else if (tensor.raw_data().size() == count * sizeof(std::int64_t)) {
    std::memcpy(whole.values.data(), tensor.raw_data().data(), tensor.raw_data().size());
  } else {
    return std::nullopt;
  }
  return whole;
}

/// Lengths where all of them are known.
std::optional<Whole> KnownShape(const onnx::TypeProto& type) {
  if (!type.has_tensor_type() || !type.tensor_type().has_shape()) return std::nullopt;
  Whole whole;
  for (const auto& length : type.tensor_type().shape().dim()) {
    if (!length.has_dim_value() || length.dim_value() < 1) return std::nullopt;
    whole.values.push_back(length.dim_value());
  }
  return whole;
}

std::int64_t AttributeOf(const onnx::NodeProto& node, const char* name, std::int64_t otherwise) {
  for (const auto& attribute : node.attribute())
    if (attribute.name() == name) return attribute.i();
  return otherwise;
}

std::optional<std::int64_t> Compute(const std::string& operation, std::int64_t a, std::int64_t b) {
  constexpr std::int64_t kLargest = std::int64_t{1} << 31;  // no sum or product overflows
  if (a > kLargest || a < -kLargest || b > kLargest || b < -kLargest) return std::nullopt;
  if (operation == "Add") return a + b;
  if (operation == "Sub") return a - b;
  if (operation == "Mul") return a * b;
  if (operation == "Div" && b != 0) return a / b;
  return std::nullopt;
}

std::optional<Whole> Elementwise(const std::string& operation, const Whole& a, const Whole& b) {
  const std::size_t size = std::max(a.values.size(), b.values.size());
  if ((a.values.size() != size && a.values.size() != 1) ||
      (b.values.size() != size && b.values.size() != 1))
    return std::nullopt;
  Whole result{{}, a.is_scalar && b.is_scalar};
  for (std::size_t i = 0; i < size; ++i) {
    const auto value = Compute(operation, a.values[a.values.size() == 1 ? 0 : i],
                               b.values[b.values.size() == 1 ? 0 : i]);
    if (!value) return std::nullopt;
    result.values.push_back(*value);
  }
  return result;
}

std::optional<Whole> Gathered(const Whole& from, const Whole& indices) {
  Whole result{{}, indices.is_scalar};
  const auto size = static_cast<std::int64_t>(from.values.size());
  for (const std::int64_t index : indices.values) {
    if (index < -size || index >= size) return std::nullopt;
    result.values.push_back(
        from.values[static_cast<std::size_t>(index < 0 ? index + size : index)]);
  }
  return result;
}

/// What is known in a graph.
class Knowledge {
 public:
  explicit Knowledge(const onnx::GraphProto& graph) {
    for (const auto& weight : graph.initializer()) Learn(weight.name(), WholeOf(weight));
    for (const auto* values : {&graph.input(), &graph.value_info()})
      for (const auto& value : *values)
        if (auto shape = KnownShape(value.type())) shapes_[value.name()] = *shape;
  }
  void Learn(const std::string& name, std::optional<Whole> whole) {
    if (whole) known_[name] = *std::move(whole);
  }
  /// What a node gives; nothing where it gives no whole numbers or they are not known.
  std::optional<Whole> Result(const onnx::NodeProto& node) const {
    const std::string& operation = node.op_type();
    if (operation == "Shape" && node.input_size() == 1) {
      const auto found = shapes_.find(node.input(0));
      return found == shapes_.end() ? std::nullopt : std::optional(found->second);
    }
    std::vector<Whole> inputs;
    for (const std::string& name : node.input()) {
      const auto found = known_.find(name);
      if (found == known_.end()) return std::nullopt;
      inputs.push_back(found->second);
    }
    if (inputs.empty()) return std::nullopt;
    if (operation == "Gather" && inputs.size() == 2 && AttributeOf(node, "axis", 0) == 0)
      return Gathered(inputs[0], inputs[1]);
    if (operation == "Unsqueeze" && inputs[0].is_scalar) return Whole{inputs[0].values, false};
    if (operation == "Squeeze" && inputs[0].values.size() == 1)
      return Whole{inputs[0].values, true};
    if (operation == "Cast" && AttributeOf(node, "to", 0) == onnx::TensorProto::INT64)
      return inputs[0];
    if (operation == "Concat") {
      Whole joined;
      for (const Whole& part : inputs)
        joined.values.insert(joined.values.end(), part.values.begin(), part.values.end());
      return joined;
    }
    return inputs.size() == 2 ? Elementwise(operation, inputs[0], inputs[1]) : std::nullopt;
  }

 private:
  std::map<std::string, Whole> known_, shapes_;
};

void AddInitializer(const std::string& name, const Whole& whole, onnx::GraphProto& graph) {
  onnx::TensorProto& tensor = *graph.add_initializer();
  tensor.set_name(name);
  tensor.set_data_type(onnx::TensorProto::INT64);
  if (!whole.is_scalar) tensor.add_dims(static_cast<std::int64_t>(whole.values.size()));
  for (const std::int64_t value : whole.values) tensor.add_int64_data(value);
}

/// Folds what is known now; how many nodes that were.
int FoldOnce(onnx::GraphProto& graph) {
  Knowledge knowledge(graph);
  std::set<std::string> outputs;  // of the graph: they must be given by nodes
  for (const auto& output : graph.output()) outputs.insert(output.name());
  int folded = 0;
  google::protobuf::RepeatedPtrField<onnx::NodeProto> kept;
  for (const onnx::NodeProto& node : graph.node()) {
    std::optional<Whole> whole;
    if (node.op_type() == "Constant") {
      for (const auto& attribute : node.attribute())
        if (attribute.name() == "value" && attribute.has_t()) whole = WholeOf(attribute.t());
      knowledge.Learn(node.output_size() == 1 ? node.output(0) : "", whole);
      *kept.Add() = node;
      continue;
    }
    if (node.output_size() == 1 && !outputs.contains(node.output(0)))
      whole = knowledge.Result(node);
    if (!whole) {
      *kept.Add() = node;
      continue;
    }
    knowledge.Learn(node.output(0), whole);
    AddInitializer(node.output(0), *whole, graph);
    ++folded;
  }
  graph.mutable_node()->Swap(&kept);
  return folded;
}

}  // namespace

void FoldShapeArithmetic(onnx::ModelProto& model) {
  const auto& nodes = model.graph().node();
  if (std::none_of(nodes.begin(), nodes.end(),
                   [](const onnx::NodeProto& node) { return node.op_type() == "Shape"; }))
    return;
  for (int round = 0; round < kMostRounds; ++round) {
    onnx::ModelProto with_shapes = model;
    try {
      onnx::shape_inference::InferShapes(with_shapes);
    } catch (const std::exception&) {
      return;  // operators that this version of ONNX does not know
    }
    if (FoldOnce(*with_shapes.mutable_graph()) == 0) return;
    with_shapes.mutable_graph()->clear_value_info();
    model = std::move(with_shapes);
  }
}

}  // namespace plumbline
