// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/detector.h"

#include "engine/vision/dense_detector.h"
#include "engine/vision/network.h"
#include "engine/vision/two_stage_detector.h"

namespace plumbline {
namespace {

class DatasetDetector : public Detector {
 public:
  explicit DatasetDetector(std::shared_ptr<const Sequence> sequence)
      : sequence_(std::move(sequence)) {}
  Result<std::unique_ptr<const FrameDetections>> Detect(const Frame& frame) override {
    Result<std::optional<std::vector<Detection>>> proposals = sequence_->ReadProposals(frame.index);
    if (!proposals.ok()) return proposals.error();
    if (!proposals->has_value()) {
      return Error{ErrorCode::kNotFound, "the sequence '" + sequence_->path().string() +
                                             "' has no proposals for frame " +
                                             std::to_string(frame.index)};
    }
    return DetectionsFromProposals(*std::move(proposals).value());
  }

 private:
  std::shared_ptr<const Sequence> sequence_;
};

}  // namespace

Result<std::unique_ptr<Detector>> CreateDetector(std::string_view choice,
                                                 std::shared_ptr<const Sequence> sequence,
                                                 const DetectorOptions& options) {
  if (choice == "dataset") {
    if (sequence == nullptr || !sequence->has_proposals()) {
      return sequence == nullptr
                 ? Error{ErrorCode::kInvalidInput, "the detector 'dataset' needs a sequence"}
                 : Error{ErrorCode::kNotFound, "the sequence '" + sequence->path().string() +
                                                   "' has no proposals/; name a detector instead "
                                                   "(builtin, FILE.onnx, or one "
                                                   "that 'plumbline networks get' has fetched)"};
    }
    return std::unique_ptr<Detector>(std::make_unique<DatasetDetector>(std::move(sequence)));
  }
  if (choice == "builtin") return BuiltinDetector(options);
  if (!choice.ends_with(".onnx")) {
    return Error{ErrorCode::kInvalidInput, "there is no detector '" + std::string(choice) +
                                               "'; it must be dataset, builtin or a FILE.onnx"};
  }
  const std::filesystem::path file(choice);
  Result<NetworkSidecar> sidecar = ReadNetworkSidecar(file);
  if (!sidecar.ok()) return sidecar.error();
  return CreateNetworkDetector(file, std::move(sidecar).value(), options);
}

Result<std::unique_ptr<Detector>> CreateNetworkDetector(const std::filesystem::path& onnx_file,
                                                        NetworkSidecar sidecar,
                                                        const DetectorOptions& options) {
  if (sidecar.kind == NetworkKind::kEdge) {
    return Error{ErrorCode::kInvalidInput, "the network '" + onnx_file.string() +
                                               "' finds edges, no objects (its sidecar's kind is "
                                               "edge); give it as --edges"};
  }
  if (sidecar.kind == NetworkKind::kTwoStage)
    return CreateTwoStageDetector(onnx_file, std::move(sidecar), options);
  Result<Network> network = LoadNetwork(onnx_file, std::move(sidecar));
  if (!network.ok()) return network.error();
  return CreateDenseDetector(std::move(network).value(), options);
}

}  // namespace plumbline
