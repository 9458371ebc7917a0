// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/edge_detector.h"

#include "engine/vision/edge_gradient.h"
#include "engine/vision/edge_network.h"

namespace plumbline {
namespace {

class DatasetEdges : public EdgeDetector {
 public:
  explicit DatasetEdges(std::shared_ptr<const Sequence> sequence)
      : sequence_(std::move(sequence)) {}
  Result<EdgeMap> Detect(const Frame& frame) override {
    Result<std::optional<EdgeMap>> edges = sequence_->ReadEdges(frame.index);
    if (!edges.ok()) return edges.error();
    if (!edges->has_value()) {
      return Error{ErrorCode::kNotFound, "the sequence '" + sequence_->path().string() +
                                             "' has no edges for frame " +
                                             std::to_string(frame.index)};
    }
    return *std::move(edges).value();
  }

 private:
  std::shared_ptr<const Sequence> sequence_;
};

}  // namespace

Result<std::unique_ptr<EdgeDetector>> CreateEdgeDetector(std::string_view choice,
                                                         std::shared_ptr<const Sequence> sequence,
                                                         const EdgeOptions& options) {
  if (choice == "gradient") return CreateGradientEdgeDetector();
  if (choice == "builtin" || choice == "builtin-half")
    return BuiltinEdgeNetwork(choice == "builtin-half", options);
  if (choice == "dataset") {
    if (sequence == nullptr)
      return Error{ErrorCode::kInvalidInput, "the edges 'dataset' need a sequence"};
    if (!sequence->has_edges()) {
      return Error{
          ErrorCode::kNotFound,
          "the sequence '" + sequence->path().string() +
              "' has no edges/; use builtin, gradient or a network of your own (FILE.onnx)"};
    }
    return std::unique_ptr<EdgeDetector>(std::make_unique<DatasetEdges>(std::move(sequence)));
  }
  if (!choice.ends_with(".onnx")) {
    return Error{ErrorCode::kInvalidInput, "there are no edges '" + std::string(choice) +
                                               "'; the choice is dataset, builtin, builtin-half, "
                                               "gradient or a FILE.onnx"};
  }
  Result<Network> network = LoadNetwork(std::filesystem::path(choice));
  if (!network.ok()) return network.error();
  return CreateEdgeNetwork(std::move(network).value(), options);
}

}  // namespace plumbline
