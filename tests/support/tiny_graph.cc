// SPDX-License-Identifier: Apache-2.0
#include "tests/support/tiny_graph.h"

#include <fstream>

#include "engine/base/check.h"

namespace plumbline {

TinyGraph::TinyGraph(const TinyNetwork& network)
    : TinyGraph(network, {1, 3, network.free_size ? 0 : network.height,
                          network.free_size ? 0 : network.width}) {}

TinyGraph::TinyGraph(const TinyNetwork& network, const std::vector<int>& input)
    : network_(network) {
  model_.set_ir_version(6);
  model_.set_producer_name("tiny");
  model_.add_opset_import()->set_version(11);
  for (const auto& [key, value] : network.metadata) {
    auto* entry = model_.add_metadata_props();
    entry->set_key(key);
    entry->set_value(value);
  }
  graph().set_name("tiny");
  AddValue(*graph().add_input(), "image", input);
  image_ = "image";
  if (network.shapes) image_ = ThroughShapes(image_);
  if (!network.clips) return;
  const std::string lowest = Floats({}, {-1000}), highest = Floats({}, {1000});
  image_ = Node("Clip", {image_, lowest, highest});
}

std::string TinyGraph::Grid(int stride, const std::vector<float>& values) {
  const int channels = static_cast<int>(values.size());
  const std::string weights =
      Floats({channels, 3, stride, stride},
             std::vector<float>(static_cast<std::size_t>(channels) * 3 * stride * stride));
  std::string bias = Floats({channels}, values);
  if (network_.copies) bias = Node("Identity", {bias});
  const std::string result = Node("Conv", {image_, weights, bias});
  SetInts("kernel_shape", {stride, stride});
  SetInts("strides", {stride, stride});
  return result;
}

std::string TinyGraph::Means(const std::string& input, int channels, int window,
                             const std::vector<float>& weights, const std::vector<float>& bias) {
  const int count = channels * window * window;
  std::vector<float> all;
  for (const float weight : weights)
    all.insert(all.end(), static_cast<std::size_t>(count), weight / static_cast<float>(count));
  const std::string weights_name =
      Floats({static_cast<int>(weights.size()), channels, window, window}, all);
  const std::string result =
      Node("Conv", {input, weights_name, Floats({static_cast<int>(bias.size())}, bias)});
  SetInts("kernel_shape", {window, window});
  SetInts("strides", {window, window});
  return result;
}

std::string TinyGraph::Flat(const std::string& grid, int channels) {
  return Node("Reshape", {grid, Wholes({1, channels, -1})});
}

std::string TinyGraph::Joined(const std::vector<std::string>& parts, int axis) {
  const std::string result = Node("Concat", parts);
  SetInt("axis", axis);
  return result;
}

std::string TinyGraph::Turned(const std::string& value) {
  const std::string result = Node("Transpose", {value});
  SetInts("perm", {0, 2, 1});
  return result;
}

std::string TinyGraph::Node(const std::string& operation, const std::vector<std::string>& inputs,
                            int outputs) {
  last_ = graph().add_node();
  last_->set_op_type(operation);
  last_->set_name(Name(operation));
  for (const std::string& input : inputs) last_->add_input(input);
  for (int i = 0; i < outputs; ++i) last_->add_output(Name("value"));
  return last_->output(0);
}

void TinyGraph::SetInt(const std::string& name, int value) {
  onnx::AttributeProto& attribute = *last_->add_attribute();
  attribute.set_name(name);
  attribute.set_type(onnx::AttributeProto::INT);
  attribute.set_i(value);
}

void TinyGraph::SetInts(const std::string& name, const std::vector<int>& values) {
  onnx::AttributeProto& attribute = *last_->add_attribute();
  attribute.set_name(name);
  attribute.set_type(onnx::AttributeProto::INTS);
  for (const int value : values) attribute.add_ints(value);
}

std::string TinyGraph::Floats(const std::vector<int>& shape, const std::vector<float>& values) {
  onnx::TensorProto& tensor = *graph().add_initializer();
  tensor.set_name(Name("floats"));
  tensor.set_data_type(onnx::TensorProto::FLOAT);
  for (const int length : shape) tensor.add_dims(length);
  for (const float value : values) tensor.add_float_data(value);
  return tensor.name();
}

std::string TinyGraph::Wholes(const std::vector<int>& values) {
  onnx::TensorProto& tensor = *graph().add_initializer();
  tensor.set_name(Name("wholes"));
  tensor.set_data_type(onnx::TensorProto::INT64);
  tensor.add_dims(static_cast<int>(values.size()));
  for (const int value : values) tensor.add_int64_data(value);
  return tensor.name();
}

std::string TinyGraph::Whole(int value) {
  const std::string name = Wholes({value});
  graph().mutable_initializer(graph().initializer_size() - 1)->clear_dims();
  return name;
}

void TinyGraph::Write(const std::filesystem::path& file) const {
  std::ofstream out(file, std::ios::binary);
  PLB_CHECK(model_.SerializeToOstream(&out));
}

std::string TinyGraph::ThroughShapes(const std::string& image) {
  const auto length = [&](const std::string& value, int axis) {
    return Node("Gather", {Node("Shape", {value}), Whole(axis)});
  };
  const auto row = [&](const std::string& number) {
    const std::string result = Node("Unsqueeze", {number});
    SetInts("axes", {0});
    return result;
  };
  const std::string rows = length(image, 2), columns = length(image, 3);
  const std::string cells = row(Node("Mul", {rows, columns}));
  const std::string flat = Node("Reshape", {image, Joined({Wholes({1, 3}), cells}, 0)});
  const std::string half = Node("Div", {Node("Add", {length(flat, 2), Whole(1)}), Whole(2)});
  const std::string first = Node("Slice", {flat, Wholes({0}), row(half), Wholes({2})});
  const std::string all = row(Node("Mul", {half, Whole(2)}));
  const std::string second = Node("Slice", {flat, row(half), all, Wholes({2})});
  const std::string shape = Joined({Wholes({1, 3}), row(rows), row(columns)}, 0);
  return Node("Reshape", {Joined({first, second}), shape});
}

void TinyGraph::AddValue(onnx::ValueInfoProto& value, const std::string& name,
                         const std::vector<int>& shape) {
  value.set_name(name);
  auto& tensor = *value.mutable_type()->mutable_tensor_type();
  tensor.set_elem_type(onnx::TensorProto::FLOAT);
  auto& lengths = *tensor.mutable_shape();
  for (const int length : shape) {
    auto& dim = *lengths.add_dim();
    if (length > 0) dim.set_dim_value(length);
    if (length == 0) dim.set_dim_param("open");
  }
}

}  // namespace plumbline
