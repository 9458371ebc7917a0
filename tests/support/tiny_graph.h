// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <onnx/onnx_pb.h>

#include "tests/support/tiny_network.h"

namespace plumbline {

/// Builds an ONNX graph (opset 11) node by node. Values have names.
class TinyGraph {
 public:
  explicit TinyGraph(const TinyNetwork& network);
  /// @param input  Its shape; 0: open.
  TinyGraph(const TinyNetwork& network, const std::vector<int>& input);

  /// A convolution without weights: channel k is values[k] everywhere on the grid of `stride`.
  std::string Grid(int stride, const std::vector<float>& values);
  /// A convolution whose channel k is weights[k] times the mean of its window, plus bias[k].
  std::string Means(const std::string& input, int channels, int window,
                    const std::vector<float>& weights, const std::vector<float>& bias);
  std::string Flattened(const std::string& value) { return Node("Flatten", {value}); }
  const std::string& image() const { return image_; }
  /// [1, channels, rows, columns] to [1, channels, cells].
  std::string Flat(const std::string& grid, int channels);
  std::string Joined(const std::vector<std::string>& parts, int axis = 2);
  std::string Turned(const std::string& value);

  /// Any node; SetInt and SetInts give the last one attributes. @return its first output.
  std::string Node(const std::string& operation, const std::vector<std::string>& inputs,
                   int outputs = 1);
  /// Other outputs of the last node.
  std::string Other(int output) const { return last_->output(output); }
  void SetInt(const std::string& name, int value);
  void SetInts(const std::string& name, const std::vector<int>& values);
  std::string Floats(const std::vector<int>& shape, const std::vector<float>& values);
  /// A row of whole numbers.
  std::string Wholes(const std::vector<int>& values);
  std::string Whole(int value);

  void Output(const std::string& value) { AddValue(*graph().add_output(), value, {}); }
  void Write(const std::filesystem::path& file) const;

 private:
  onnx::GraphProto& graph() { return *model_.mutable_graph(); }
  std::string Name(const std::string& what) { return what + std::to_string(++names_); }
  /// `image` unchanged, by `view` and `chunk` as torch 1.13 writes them.
  std::string ThroughShapes(const std::string& image);
  static void AddValue(onnx::ValueInfoProto& value, const std::string& name,
                       const std::vector<int>& shape);

  TinyNetwork network_;
  onnx::ModelProto model_;
  onnx::NodeProto* last_ = nullptr;
  std::string image_;
  int names_ = 0;
};

}  // namespace plumbline
