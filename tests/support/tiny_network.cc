// SPDX-License-Identifier: Apache-2.0
#include "tests/support/tiny_network.h"

#include <cmath>
#include <fstream>
#include <vector>

#include <onnx/onnx_pb.h>

#include "engine/base/check.h"

namespace plumbline {
namespace {

constexpr float kHalfBox = 8;  // [px of the input]
constexpr float kPlace = 32;   // of boxes that do not follow their cell [px of the input]
constexpr int kBins = 8;       // of distances, as GFL heads have them

/// Builds a graph node by node.
class Graph {
 public:
  explicit Graph(const TinyNetwork& network)
      : Graph(network, {1, 3, network.free_size ? 0 : network.height,
                        network.free_size ? 0 : network.width}) {}
  /// @param input  Its shape; 0: open.
  Graph(const TinyNetwork& network, const std::vector<int>& input) : network_(network) {
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
    if (!network.clips) return;
    AddFloats("lowest", {}, {-1000});
    AddFloats("highest", {}, {1000});
    image_ = Node("Clip", {"image", "lowest", "highest"});
  }

  /// A convolution without weights: channel k is values[k] everywhere on the grid of `stride`.
  std::string Grid(int stride, const std::vector<float>& values) {
    const int channels = static_cast<int>(values.size());
    const std::string weights = Name("weights");
    std::string bias = Name("bias");
    AddFloats(weights, {channels, 3, stride, stride},
              std::vector<float>(static_cast<std::size_t>(channels) * 3 * stride * stride));
    AddFloats(bias, {channels}, values);
    if (network_.copies) bias = Node("Identity", {bias});
    const std::string result = Node("Conv", {image_, weights, bias});
    SetInts("kernel_shape", {stride, stride});
    SetInts("strides", {stride, stride});
    return result;
  }
  /// A convolution whose channel k is weights[k] times the mean of its window, plus bias[k].
  std::string Means(const std::string& input, int channels, int window,
                    const std::vector<float>& weights, const std::vector<float>& bias) {
    const std::string weights_name = Name("weights"), bias_name = Name("bias");
    const int count = channels * window * window;
    std::vector<float> all;
    for (const float weight : weights)
      all.insert(all.end(), static_cast<std::size_t>(count), weight / static_cast<float>(count));
    AddFloats(weights_name, {static_cast<int>(weights.size()), channels, window, window}, all);
    AddFloats(bias_name, {static_cast<int>(bias.size())}, bias);
    const std::string result = Node("Conv", {input, weights_name, bias_name});
    SetInts("kernel_shape", {window, window});
    SetInts("strides", {window, window});
    return result;
  }
  std::string Flattened(const std::string& value) { return Node("Flatten", {value}); }
  const std::string& image() const { return image_; }
  /// [1, channels, rows, columns] to [1, channels, cells].
  std::string Flat(const std::string& grid, int channels) {
    const std::string shape = Name("shape");
    onnx::TensorProto& tensor = *graph().add_initializer();
    tensor.set_name(shape);
    tensor.set_data_type(onnx::TensorProto::INT64);
    tensor.add_dims(3);
    for (const int length : {1, channels, -1}) tensor.add_int64_data(length);
    return Node("Reshape", {grid, shape});
  }
  std::string Joined(const std::vector<std::string>& parts) {
    const std::string result = Node("Concat", parts);
    onnx::AttributeProto& axis = *last_->add_attribute();
    axis.set_name("axis");
    axis.set_type(onnx::AttributeProto::INT);
    axis.set_i(2);
    return result;
  }
  std::string Turned(const std::string& value) {
    const std::string result = Node("Transpose", {value});
    SetInts("perm", {0, 2, 1});
    return result;
  }
  void Output(const std::string& value) { AddValue(*graph().add_output(), value, {}); }

  void Write(const std::filesystem::path& file) const {
    std::ofstream out(file, std::ios::binary);
    PLB_CHECK(model_.SerializeToOstream(&out));
  }

 private:
  onnx::GraphProto& graph() { return *model_.mutable_graph(); }
  std::string Name(const std::string& what) { return what + std::to_string(++names_); }

  std::string Node(const std::string& operation, const std::vector<std::string>& inputs) {
    last_ = graph().add_node();
    last_->set_op_type(operation);
    last_->set_name(Name(operation));
    for (const std::string& input : inputs) last_->add_input(input);
    last_->add_output(Name("value"));
    return last_->output(0);
  }
  void SetInts(const std::string& name, const std::vector<int>& values) {
    onnx::AttributeProto& attribute = *last_->add_attribute();
    attribute.set_name(name);
    attribute.set_type(onnx::AttributeProto::INTS);
    for (const int value : values) attribute.add_ints(value);
  }
  void AddFloats(const std::string& name, const std::vector<int>& shape,
                 const std::vector<float>& values) {
    onnx::TensorProto& tensor = *graph().add_initializer();
    tensor.set_name(name);
    tensor.set_data_type(onnx::TensorProto::FLOAT);
    for (const int length : shape) tensor.add_dims(length);
    for (const float value : values) tensor.add_float_data(value);
  }
  static void AddValue(onnx::ValueInfoProto& value, const std::string& name,
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

  const TinyNetwork& network_;
  onnx::ModelProto model_;
  onnx::NodeProto* last_ = nullptr;
  std::string image_;
  int names_ = 0;
};

/// `front`, then a score for each category.
std::vector<float> WithScores(std::vector<float> front, const TinyNetwork& network) {
  for (int i = 0; i < network.categories; ++i)
    front.push_back(i == network.best_category ? network.score : 0);
  return front;
}

/// Logits over whole strides whose mean is kHalfBox, for the four sides.
std::vector<float> Distances(int stride) {
  // Between two bins; where the box is under a stride, bins 0 and 1.
  const float strides = kHalfBox / static_cast<float>(stride);
  const int lower = static_cast<int>(strides);
  const float upper_share = strides - static_cast<float>(lower);
  std::vector<float> logits;
  for (int side = 0; side < 4; ++side) {
    for (int bin = 0; bin < kBins; ++bin) {
      const float share = bin == lower ? 1 - upper_share : bin == lower + 1 ? upper_share : 0;
      logits.push_back(share > 0 ? std::log(share) : -50);
    }
  }
  return logits;
}

}  // namespace

void WriteTinyNetwork(const std::filesystem::path& file, const TinyNetwork& network) {
  Graph graph(network);
  const float box = 2 * kHalfBox;
  const std::vector<int> three = {8, 16, 32}, four = {8, 16, 32, 64};
  std::vector<std::string> parts;
  switch (network.kind) {
    case NetworkKind::kEdge:
      graph.Output(graph.Grid(1, {network.score}));
      break;
    case NetworkKind::kFastestDet: {
      // Half the size that a sigmoid gives, as a share of the image.
      const auto logit = [](float share) { return std::log(share / (1 - share)); };
      graph.Output(graph.Grid(16, WithScores({1, std::atanh(0.5f), std::atanh(0.5f),
                                              logit(box / static_cast<float>(network.width)),
                                              logit(box / static_cast<float>(network.height))},
                                             network)));
      break;
    }
    case NetworkKind::kYolox:
      for (const int stride : three) {
        const auto values = WithScores({0.5f, 0.5f, std::log(box / static_cast<float>(stride)),
                                        std::log(box / static_cast<float>(stride)), 1},
                                       network);
        parts.push_back(graph.Flat(graph.Grid(stride, values), static_cast<int>(values.size())));
      }
      graph.Output(graph.Turned(graph.Joined(parts)));
      break;
    case NetworkKind::kYolov5:
    case NetworkKind::kYolov8: {
      const bool five = network.kind == NetworkKind::kYolov5;
      std::vector<float> values = {kPlace, kPlace, box, box};
      if (five) values.push_back(1);
      values = WithScores(values, network);
      for (int anchor = 0; anchor < (five ? 3 : 1); ++anchor)
        for (const int stride : three)
          parts.push_back(graph.Flat(graph.Grid(stride, values), static_cast<int>(values.size())));
      const std::string joined = graph.Joined(parts);
      graph.Output(five ? graph.Turned(joined) : joined);
      break;
    }
    case NetworkKind::kPicodet:
      for (const int stride : four) {
        graph.Output(graph.Turned(
            graph.Flat(graph.Grid(stride, WithScores({}, network)), network.categories)));
        graph.Output(graph.Turned(graph.Flat(graph.Grid(stride, Distances(stride)), 4 * kBins)));
      }
      break;
    case NetworkKind::kNanodet:
      for (const int stride : four) {
        std::vector<float> values = WithScores({}, network);
        for (const float logit : Distances(stride)) values.push_back(logit);
        parts.push_back(graph.Flat(graph.Grid(stride, values), static_cast<int>(values.size())));
      }
      graph.Output(graph.Turned(graph.Joined(parts)));
      break;
    case NetworkKind::kSsd: {
      const auto width = static_cast<float>(network.width),
                 height = static_cast<float>(network.height);
      graph.Output(graph.Turned(graph.Flat(graph.Grid(16, WithScores({1 - network.score}, network)),
                                           1 + network.categories)));
      graph.Output(graph.Turned(
          graph.Flat(graph.Grid(16, {(kPlace - kHalfBox) / width, (kPlace - kHalfBox) / height,
                                     (kPlace + kHalfBox) / width, (kPlace + kHalfBox) / height}),
                     4)));
      break;
    }
    case NetworkKind::kTwoStage:
      PLB_CHECK(false);
  }
  graph.Write(file);
}

void WriteTinyTwoStage(const std::filesystem::path& file, int head_categories) {
  const TinyNetwork tiny;
  Graph trunk(tiny);
  // The feature, the objectness of one anchor, its four deltas.
  trunk.Output(trunk.Means(trunk.image(), 3, 8, {1, 20, 0, 0, 0, 0}, {0, -10, 0, 0, 0, 0}));
  trunk.Write(file);
  Graph head(tiny, {32, 1, 7, 7});
  const auto classes = static_cast<std::size_t>(1 + head_categories);
  std::vector<float> weights(5 * classes), bias(5 * classes);
  for (std::size_t category = 1; category < classes; ++category) bias[category] = -30;
  weights[2] = 20;
  bias[2] = -10;
  head.Output(head.Flattened(head.Means(head.image(), 1, 7, weights, bias)));
  head.Write(std::filesystem::path(file).replace_extension(".head.onnx"));
  std::ofstream(std::filesystem::path(file).replace_extension(".json")) << R"({
    "kind": "two_stage", "width": 64, "height": 64, "resize": "letterbox", "strides": [8],
    "scale": 0.00392156862745098, "categories": ["chair", "couch"],
    "anchors": [{"sizes": [16], "ratios": [1]}],
    "rpn": {"before_nms": 50, "after_nms": 20, "nms_iou": 0.7, "min_score": 0.5,
            "weights": [1, 1, 1, 1]},
    "crops": {"size": 7, "sampling": 2, "levels": 1, "canonical_scale": 224, "canonical_level": 4},
    "boxes": {"weights": [10, 10, 5, 5], "most": 100}})";
}

}  // namespace plumbline
