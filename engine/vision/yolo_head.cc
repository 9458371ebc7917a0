// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/yolo_head.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <onnx/onnx_pb.h>

namespace plumbline {
namespace {

constexpr std::size_t kMostNodes = 1000;  // such ends have 40 to 300

/// The last convolutions of a level: distances of a box's sides, scores of categories.
struct YoloLevel {
  std::string sides, scores;
};
struct YoloHead {
  std::vector<YoloLevel> levels;
  int bins = 1, categories = 0;
};

/// The end of a network, from an output back to its last convolutions.
class End {
 public:
  End(const onnx::GraphProto& graph, const std::string& output) {
    for (const auto& weight : graph.initializer()) weights_[weight.name()] = &weight;
    for (const auto& node : graph.node())
      for (const std::string& value : node.output()) makers_[value] = &node;
    Walk(output);
  }

  std::optional<YoloHead> Yolo() const {
    // Distances become corners by adding and subtracting; whatever else is done to boxes is another
    // kind of network.
    for (const char* needed : {"Sub", "Add", "Sigmoid"})
      if (!operations_.contains(needed)) return std::nullopt;
    for (const char* other : {"Exp", "Pow", "Relu", "Cos"})
      if (operations_.contains(other)) return std::nullopt;
    // Of every level sides, scores and perhaps something else: coefficients of masks, key points.
    const std::size_t count = last_.size();
    const std::size_t levels = count == 6 || count == 9 ? 3 : count == 8 || count == 12 ? 4 : 0;
    if (levels == 0) return std::nullopt;
    // Sides and scores meet level by level, or all sides and all scores.
    const bool by_level = Meet(last_[0], last_[1]);
    YoloHead head;
    head.bins = bins_;
    head.categories = Length(*last_[by_level ? 1 : levels], 0);
    for (std::size_t i = 0; i < levels; ++i) {
      const onnx::NodeProto* sides = last_[by_level ? 2 * i : i];
      const onnx::NodeProto* scores = last_[by_level ? 2 * i + 1 : levels + i];
      if (Length(*sides, 0) != 4 * bins_ || Length(*scores, 0) != head.categories)
        return std::nullopt;
      head.levels.push_back({sides->output(0), scores->output(0)});
    }
    if (head.categories < 1) return std::nullopt;
    return head;
  }

 private:
  /// Inputs in their order: boxes come before scores, scores before anything else.
  void Walk(const std::string& value) {
    const auto found = makers_.find(value);
    if (found == makers_.end() || visited_.size() >= kMostNodes) return;
    const onnx::NodeProto& node = *found->second;
    if (!visited_.insert(&node).second || node.op_type() == "Shape") return;
    if (node.op_type() == "Conv") {
      if (node.input_size() > 2 || Length(node, 0) != 1) {
        last_.push_back(&node);
        return;
      }
      bins_ = Length(node, 1);  // without a bias, to one channel: the mean of a distribution
    }
    operations_.insert(node.op_type());
    for (const std::string& input : node.input()) Walk(input);
  }
  /// Of a convolution's weights: 0 along its outputs, 1 along its inputs.
  int Length(const onnx::NodeProto& convolution, int axis) const {
    const auto weight = weights_.find(convolution.input_size() > 1 ? convolution.input(1) : "");
    if (weight == weights_.end() || weight->second->dims_size() != 4) return 0;
    return static_cast<int>(weight->second->dims(axis));
  }
  bool Meet(const onnx::NodeProto* a, const onnx::NodeProto* b) const {
    return std::any_of(visited_.begin(), visited_.end(), [&](const onnx::NodeProto* node) {
      const auto takes = [&](const onnx::NodeProto* from) {
        return std::count(node->input().begin(), node->input().end(), from->output(0)) > 0;
      };
      return takes(a) && takes(b);
    });
  }

  std::map<std::string, const onnx::TensorProto*> weights_;
  std::map<std::string, const onnx::NodeProto*> makers_;
  std::set<const onnx::NodeProto*> visited_;
  std::set<std::string> operations_;
  std::vector<const onnx::NodeProto*> last_;  ///< Convolutions.
  int bins_ = 1;
};

/// Adds nodes at the end of a graph.
class Builder {
 public:
  explicit Builder(onnx::GraphProto& graph) : graph_(graph) {}

  std::string Reshaped(const std::string& value, const std::vector<int>& shape) {
    onnx::TensorProto& tensor = *graph_.add_initializer();
    tensor.set_name(Name());
    tensor.set_data_type(onnx::TensorProto::INT64);
    tensor.add_dims(static_cast<int>(shape.size()));
    for (const int length : shape) tensor.add_int64_data(length);
    return Node("Reshape", {value, tensor.name()});
  }
  /// Grids of levels, [1, channels, rows, columns] each, as one table [1, cells, channels].
  std::string Table(const std::vector<std::string>& grids, int channels, bool sigmoid) {
    std::vector<std::string> flat;
    for (const std::string& grid : grids) flat.push_back(Reshaped(grid, {1, channels, -1}));
    std::string joined = Node("Concat", flat);
    onnx::AttributeProto& axis = Attribute("axis", onnx::AttributeProto::INT);
    axis.set_i(2);
    if (sigmoid) joined = Node("Sigmoid", {joined});
    const std::string table = Node("Transpose", {joined});
    onnx::AttributeProto& order = Attribute("perm", onnx::AttributeProto::INTS);
    for (const int old_axis : {0, 2, 1}) order.add_ints(old_axis);
    return table;
  }
  /// @param shape  0: open.
  void Output(const std::string& value, const std::vector<int>& shape) {
    onnx::ValueInfoProto& output = *graph_.add_output();
    output.set_name(value);
    auto& tensor = *output.mutable_type()->mutable_tensor_type();
    tensor.set_elem_type(onnx::TensorProto::FLOAT);
    for (const int length : shape) {
      auto& dimension = *tensor.mutable_shape()->add_dim();
      if (length > 0) dimension.set_dim_value(length);
    }
  }

 private:
  std::string Name() { return "plumbline_" + std::to_string(++names_); }
  std::string Node(const char* operation, const std::vector<std::string>& inputs) {
    last_ = graph_.add_node();
    last_->set_op_type(operation);
    last_->set_name(Name());
    for (const std::string& input : inputs) last_->add_input(input);
    last_->add_output(Name());
    return last_->output(0);
  }
  onnx::AttributeProto& Attribute(const char* name, onnx::AttributeProto::AttributeType type) {
    onnx::AttributeProto& attribute = *last_->add_attribute();
    attribute.set_name(name);
    attribute.set_type(type);
    return attribute;
  }

  onnx::GraphProto& graph_;
  onnx::NodeProto* last_ = nullptr;
  int names_ = 0;
};

/// Nodes come after what they need: from the last to the first, what nobody needs goes.
void DropUnused(onnx::GraphProto& graph) {
  std::set<std::string> needed;
  for (const auto& output : graph.output()) needed.insert(output.name());
  google::protobuf::RepeatedPtrField<onnx::NodeProto> kept;
  for (int i = graph.node_size() - 1; i >= 0; --i) {
    onnx::NodeProto& node = *graph.mutable_node(i);
    if (std::none_of(node.output().begin(), node.output().end(),
                     [&](const std::string& value) { return needed.contains(value); }))
      continue;
    needed.insert(node.input().begin(), node.input().end());
    *kept.Add() = std::move(node);
  }
  std::reverse(kept.pointer_begin(), kept.pointer_end());
  graph.mutable_node()->Swap(&kept);
}

}  // namespace

bool LeaveOutBoxDecoding(onnx::GraphProto& graph) {
  std::optional<YoloHead> head;
  for (const auto& output : graph.output())
    if (!head) head = End(graph, output.name()).Yolo();
  if (!head) return false;
  std::vector<std::string> sides, scores;
  for (const YoloLevel& level : head->levels) {
    sides.push_back(level.sides);
    scores.push_back(level.scores);
  }
  graph.clear_output();
  Builder builder(graph);
  const std::string distances = builder.Table(sides, 4 * head->bins, false);
  builder.Output(builder.Reshaped(distances, {1, -1, 4, head->bins}), {1, 0, 4, head->bins});
  builder.Output(builder.Table(scores, head->categories, true), {1, 0, head->categories});
  DropUnused(graph);
  return true;
}

}  // namespace plumbline
