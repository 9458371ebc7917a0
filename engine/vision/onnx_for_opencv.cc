// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/onnx_for_opencv.h"

#include <cstdint>
#include <cstring>
#include <map>
#include <set>
#include <vector>

#include <onnx/onnx_pb.h>
#include <Eigen/Core>

#include "engine/base/check.h"
#include "engine/vision/onnx_folding.h"
#include "engine/vision/yolo_head.h"

namespace plumbline {
namespace {

void DropWeightsFromInputs(onnx::GraphProto& graph, const std::set<std::string>& weights) {
  for (int i = graph.input_size() - 1; i >= 0; --i)
    if (weights.contains(graph.input(i).name())) graph.mutable_input()->DeleteSubrange(i, 1);
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

template <typename Number, typename Field>
std::vector<Number> NumbersOf(const onnx::TensorProto& tensor, const Field& field) {
  std::vector<Number> numbers(field.begin(), field.end());
  if (!numbers.empty()) return numbers;
  numbers.resize(tensor.raw_data().size() / sizeof(Number));
  if (numbers.empty()) return numbers;
  std::memcpy(numbers.data(), tensor.raw_data().data(), numbers.size() * sizeof(Number));
  return numbers;
}

/// Numbers of 16 bits become ones of 32.
void WidenTensor(onnx::TensorProto& tensor) {
  if (tensor.data_type() != onnx::TensorProto::FLOAT16) return;
  const auto halves = NumbersOf<std::uint16_t>(tensor, tensor.int32_data());
  std::vector<float> numbers;
  numbers.reserve(halves.size());
  for (const std::uint16_t half : halves)
    numbers.push_back(static_cast<float>(Eigen::half(Eigen::half_impl::raw_uint16_to_half(half))));
  tensor.clear_int32_data();
  tensor.set_data_type(onnx::TensorProto::FLOAT);
  tensor.set_raw_data(numbers.data(), numbers.size() * sizeof(float));
}

void WidenType(onnx::ValueInfoProto& value) {
  if (!value.type().has_tensor_type()) return;
  onnx::TypeProto::Tensor& type = *value.mutable_type()->mutable_tensor_type();
  if (type.elem_type() == onnx::TensorProto::FLOAT16) type.set_elem_type(onnx::TensorProto::FLOAT);
}

/// A network of half precision as one of single precision.
void WidenHalves(onnx::GraphProto& graph) {
  for (onnx::TensorProto& weight : *graph.mutable_initializer()) WidenTensor(weight);
  for (auto* values : {graph.mutable_input(), graph.mutable_output(), graph.mutable_value_info()})
    for (onnx::ValueInfoProto& value : *values) WidenType(value);
  for (onnx::NodeProto& node : *graph.mutable_node()) {
    for (onnx::AttributeProto& attribute : *node.mutable_attribute()) {
      if (attribute.has_t()) WidenTensor(*attribute.mutable_t());
      if (node.op_type() == "Cast" && attribute.name() == "to" &&
          attribute.i() == onnx::TensorProto::FLOAT16)
        attribute.set_i(onnx::TensorProto::FLOAT);
    }
  }
}

/// Constants by name: those of the graph, and those that nodes give.
std::map<std::string, const onnx::TensorProto*> ConstantsOf(const onnx::GraphProto& graph) {
  std::map<std::string, const onnx::TensorProto*> constants;
  for (const auto& weight : graph.initializer()) constants[weight.name()] = &weight;
  for (const auto& node : graph.node()) {
    if (node.op_type() != "Constant" || node.output_size() != 1) continue;
    for (const auto& attribute : node.attribute())
      if (attribute.name() == "value" && attribute.has_t())
        constants[node.output(0)] = &attribute.t();
  }
  return constants;
}

/// An input that is a constant becomes an attribute. False: it is none of that kind.
bool AddAttribute(const onnx::TensorProto& constant, const char* name, onnx::NodeProto& node) {
  onnx::AttributeProto attribute;
  attribute.set_name(name);
  if (constant.data_type() == onnx::TensorProto::FLOAT) {
    const auto numbers = NumbersOf<float>(constant, constant.float_data());
    if (numbers.size() != 1) return false;
    attribute.set_type(onnx::AttributeProto::FLOAT);
    attribute.set_f(numbers[0]);
  } else if (constant.data_type() == onnx::TensorProto::INT64) {
    attribute.set_type(onnx::AttributeProto::INTS);
    for (const std::int64_t number : NumbersOf<std::int64_t>(constant, constant.int64_data()))
      attribute.add_ints(number);
  } else {
    return false;
  }
  *node.add_attribute() = attribute;
  return true;
}

/// OpenCV 4.6 refuses bounds of Clip that are inputs, and takes all parts of Split as equal. Names
/// of constants that nobody uses then stay in the file: they do no harm.
void MoveInputsToAttributes(onnx::GraphProto& graph) {
  static const std::map<std::string, std::vector<const char*>> kNames = {{"Clip", {"min", "max"}},
                                                                         {"Split", {"split"}}};
  const auto constants = ConstantsOf(graph);
  for (auto& node : *graph.mutable_node()) {
    const auto names = kNames.find(node.op_type());
    if (names == kNames.end() || node.input_size() < 2 ||
        node.input_size() > 1 + static_cast<int>(names->second.size()))
      continue;
    onnx::NodeProto moved = node;
    moved.mutable_input()->DeleteSubrange(1, node.input_size() - 1);
    bool all_known = true;
    for (int i = 1; i < node.input_size(); ++i) {
      if (node.input(i).empty()) continue;
      const auto found = constants.find(node.input(i));
      all_known =
          all_known && found != constants.end() &&
          AddAttribute(*found->second, names->second[static_cast<std::size_t>(i - 1)], moved);
    }
    if (all_known) node = std::move(moved);
  }
}

/// OpenCV 4.6 forgets a factor, a sum or an activation that follows a product of two computed
/// matrices (attention: scores are scaled so), unless something stands between.
void KeepProductsApart(onnx::GraphProto& graph, const std::set<std::string>& weights) {
  google::protobuf::RepeatedPtrField<onnx::NodeProto> nodes;
  for (onnx::NodeProto& from : *graph.mutable_node()) {
    onnx::NodeProto& node = *nodes.Add();
    node = std::move(from);
    if (node.op_type() != "MatMul" || node.input_size() != 2 || node.output_size() != 1 ||
        weights.contains(node.input(0)) || weights.contains(node.input(1)))
      continue;
    onnx::NodeProto& between = *nodes.Add();
    between.set_op_type("Identity");
    between.set_name(node.output(0) + "_between");
    between.add_output(node.output(0));
    between.add_input(node.output(0) + "_product");
    node.set_output(0, between.input(0));
  }
  graph.mutable_node()->Swap(&nodes);
}

/// One colour image of this size, where the file leaves lengths open.
void CloseInput(cv::Size size, onnx::GraphProto& graph) {
  constexpr int kColours = 3;
  for (auto& input : *graph.mutable_input()) {
    auto& shape = *input.mutable_type()->mutable_tensor_type()->mutable_shape();
    if (shape.dim_size() != 4 || shape.dim(1).dim_value() != kColours) continue;
    const int lengths[] = {1, kColours, size.height, size.width};
    for (int i = 0; i < 4; ++i)
      if (shape.dim(i).dim_value() < 1) shape.mutable_dim(i)->set_dim_value(lengths[i]);
  }
}

}  // namespace

std::string OnnxForOpenCv(const std::string& bytes, std::optional<cv::Size> input) {
  onnx::ModelProto model;
  PLB_CHECK(model.ParseFromString(bytes));
  onnx::GraphProto& graph = *model.mutable_graph();
  WidenHalves(graph);
  std::set<std::string> weights;
  for (const auto& weight : graph.initializer()) weights.insert(weight.name());
  DropWeightsFromInputs(graph, weights);
  DropCopiesOfConstants(graph, weights);
  LeaveOutBoxDecoding(graph);
  if (input) CloseInput(*input, graph);
  FoldShapeArithmetic(model);
  MoveInputsToAttributes(*model.mutable_graph());
  KeepProductsApart(*model.mutable_graph(), weights);
  return model.SerializeAsString();
}

}  // namespace plumbline
