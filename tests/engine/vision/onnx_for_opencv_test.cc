// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/onnx_for_opencv.h"

#include <cstdint>
#include <cstring>

#include <gtest/gtest.h>

#include "engine/base/files.h"
#include "engine/vision/network.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_graph.h"

namespace plumbline {
namespace {

constexpr int kSide = 8;
const TinyNetwork kTiny = {.width = kSide, .height = kSide};

/// What a graph makes of numbers, [1, 3, kSide, kSide].
std::vector<cv::Mat> Outputs(const TinyGraph& graph, const cv::Mat& input) {
  const TemporaryFolder folder;
  graph.Write(folder.path() / "net.onnx");
  const std::string bytes = ReadFile(folder.path() / "net.onnx").value();
  Network network = MakeNetwork(OnnxForOpenCv(bytes, std::nullopt), {}, "tiny", "").value();
  return RunNetworkOn(network, input).value();
}

cv::Mat Numbers() {
  const int shape[] = {1, 3, kSide, kSide};
  cv::Mat numbers(4, shape, CV_32FC1);
  cv::RNG random(1);
  random.fill(numbers, cv::RNG::UNIFORM, -1, 1);
  return numbers;
}

TEST(OnnxForOpenCv, KeepsTheFactorAfterAProductOfMatrices) {
  TinyGraph graph(kTiny);
  const std::string product = graph.Node("MatMul", {graph.image(), graph.image()});
  graph.Output(graph.Node("Mul", {product, graph.Floats({}, {0.5f})}));
  cv::Mat numbers = Numbers();
  const cv::Mat output = Outputs(graph, numbers).at(0);
  for (int channel = 0; channel < 3; ++channel) {
    const cv::Mat a(kSide, kSide, CV_32FC1, numbers.ptr<float>(0, channel));
    const cv::Mat wanted = 0.5 * a * a;
    const cv::Mat found(kSide, kSide, CV_32FC1, const_cast<float*>(output.ptr<float>(0, channel)));
    EXPECT_LT(cv::norm(found, wanted, cv::NORM_INF), 1e-5);
  }
}

TEST(OnnxForOpenCv, SplitsIntoPartsOfTheGivenLengths) {
  TinyGraph graph(kTiny);
  const std::string first = graph.Node("Split", {graph.image(), graph.Wholes({1, 2})}, 2);
  const std::string second = graph.Other(1);
  graph.SetInt("axis", 1);
  graph.Output(graph.Node("Sigmoid", {first}));
  graph.Output(graph.Node("Sigmoid", {second}));
  const std::vector<cv::Mat> outputs = Outputs(graph, Numbers());
  ASSERT_EQ(outputs.size(), 2u);
  EXPECT_EQ(outputs[0].size[1], 1);
  EXPECT_EQ(outputs[1].size[1], 2);
}

TEST(OnnxForOpenCv, TakesNumbersOfSixteenBits) {
  TinyGraph graph(kTiny);
  graph.Output(graph.Node("Mul", {graph.image(), graph.Floats({2}, {0.5f, -3})}));
  const TemporaryFolder folder;
  graph.Write(folder.path() / "net.onnx");
  onnx::ModelProto model;
  ASSERT_TRUE(model.ParseFromString(ReadFile(folder.path() / "net.onnx").value()));
  int halves = 0;
  for (onnx::TensorProto& tensor : *model.mutable_graph()->mutable_initializer()) {
    if (tensor.dims_size() != 1 || tensor.dims(0) != 2) continue;
    const std::uint16_t numbers[] = {0x3800, 0xC200};  // 0.5, -3
    tensor.clear_float_data();
    tensor.set_data_type(onnx::TensorProto::FLOAT16);
    tensor.set_raw_data(numbers, sizeof(numbers));
    ++halves;
  }
  ASSERT_EQ(halves, 1);
  onnx::ModelProto widened;
  ASSERT_TRUE(widened.ParseFromString(OnnxForOpenCv(model.SerializeAsString(), std::nullopt)));
  for (const onnx::TensorProto& tensor : widened.graph().initializer()) {
    ASSERT_EQ(tensor.data_type(), onnx::TensorProto::FLOAT);
    if (tensor.raw_data().size() != 2 * sizeof(float)) continue;
    float numbers[2];
    std::memcpy(numbers, tensor.raw_data().data(), sizeof(numbers));
    EXPECT_EQ(numbers[0], 0.5f);
    EXPECT_EQ(numbers[1], -3);
    --halves;
  }
  EXPECT_EQ(halves, 0);
}

}  // namespace
}  // namespace plumbline
